#include "mtled/solve/solve_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/interrupt.h"
#include "base/key.h"
#include "batch/static_solver.h"
#include "io/csv_table.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "mtled/run/checkpoint.h"
#include "setup/body_points.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/interrupted_child.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

/// A small block pressed between plates, in four load steps.
const std::string block_scene = test::block_text + R"([[prescribed]]
name = "plate"
shape = "near-plane"
point = [0, 0, 0.03]
normal = [0, 0, 1]
distance = 1e-6
translation = [0.001, 0, -0.003]
duration = 1
[solve]
tolerance = 1e-5
load_steps = 4
frames = 2
end_time = 1
probes = "probes.csv"
)";

const std::string probes = "name,X,Y,Z\n1,0,0,0.015\n2,0.01,-0.02,0.03\n3,0.0299,0.01,0.007\n";

/// Runs the command quietly.
int solve(const std::string& scene, const std::string& out, bool resume = false, const std::string& script = "",
          bool strict = false) {
  const CapturedOutput quiet;
  SolveOptions options;
  options.scene = scene;
  options.out = out;
  options.tool_script = script;
  options.threads = 1;
  options.resume = resume;
  options.strict = strict;
  return solveCommand(options);
}

struct Folder : TempFolder {
  std::string scene;
  explicit Folder(const std::string& text = block_scene) {
    write("probes.csv", probes);
    scene = write("block.toml", text);
  }
  std::string out(const std::string& file = "") const { return path("out") + (file.empty() ? "" : "/" + file); }
};

nlohmann::json reportIn(const Folder& folder) { return nlohmann::json::parse(readAll(folder.out("report.json"))); }

}  // namespace

TEST_CASE("A solution leaves its force curve, pictures, probes and report", "[solve_command]") {
  const Folder folder;
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const CsvTable force = readCsvTable(folder.out("force.csv"));
  CHECK(force.rowCount() == 4);
  for (const char* boundary : {"base", "plate", "tool"})
    for (const char* part : {"_fx_N", "_fy_N", "_fz_N"}) CHECK(force.find(std::string(boundary) + part) >= 0);
  for (const char* part : {"_mx_Nm", "_my_Nm", "_mz_Nm"}) CHECK(force.find(std::string("plate") + part) >= 0);
  for (std::size_t r = 0; r < 4; ++r) {
    CHECK(force["time_s"][r] == Approx(0.25 * static_cast<double>(r + 1)).epsilon(1e-12));
    CHECK(force["plate_fz_N"][r] == Approx(-force["base_fz_N"][r]).epsilon(1e-3));
    CHECK(force["plate_fz_N"][r] < (r == 0 ? 0 : force["plate_fz_N"][r - 1]));  // harder with each step
    CHECK(force["tool_fz_N"][r] == 0);
    CHECK(force["inverted_points"][r] == 0);
  }

  // Two frames, at half the time and at the end.
  CHECK(std::filesystem::exists(folder.out("solution_0000.vtu")));
  CHECK(std::filesystem::exists(folder.out("solution_0001.vtu")));
  CHECK_FALSE(std::filesystem::exists(folder.out("solution_0002.vtu")));
  const std::string collection = readAll(folder.out("solution.pvd")), vtu = readAll(folder.out("solution_0001.vtu"));
  CHECK_THAT(collection, Contains("timestep=\"0.5\"") && Contains("timestep=\"1\"") && Contains("solution_0001.vtu"));
  CHECK_THAT(
      vtu, Contains("displacement_m") && Contains("reaction_N") && Contains("von_Mises_Pa") && Contains("pressure_Pa"));

  const auto report = reportIn(folder);
  CHECK(report["converged"] == true);
  CHECK(report["diverged"] == false);
  CHECK(report["rows"] == 4);
  CHECK(report["frames"] == 2);
  CHECK(report["time_s"] == 1.0);
  CHECK(report["reactions"]["plate"]["force_N"][2].get<double>() == Approx(force["plate_fz_N"][3]).epsilon(1e-12));
}

TEST_CASE("Each row says whether it can be trusted, and a strict solution fails where one can't",
          "[solve_command][whole]") {
  // Confined tissue of nu 0.499 to ten shear moduli of pressure: the paper's scheme gives way, the standard is exact.
  std::string confined = replaced(block_scene, "poisson = 0.45", "poisson = 0.499");
  confined = replaced(confined, "translation = [0.001, 0, -0.003]", "translation = [0, 0, -0.0006]");
  for (const char* wall : {"[0.03, 0, 0]", "[-0.03, 0, 0]", "[0, 0.03, 0]", "[0, -0.03, 0]"}) {
    const std::string at(wall);
    const bool x = at.find("[0,") != 0;
    confined += "[[fixed]]\nshape = \"near-plane\"\npoint = " + at + "\nnormal = " + (x ? "[1, 0, 0]" : "[0, 1, 0]") +
                "\ndistance = 1e-6\ncomponents = [\"" + (x ? "x" : "y") + "\"]\n";
  }
  const Folder standard(confined), paper(replaced(confined, "spacing = 0.012", "spacing = 0.012\nscheme = \"paper\""));
  REQUIRE(solve(standard.scene, standard.out(), false, "", true) == 0);
  const CsvTable good = readCsvTable(standard.out("force.csv"));
  CHECK(good.trust == std::vector<std::string>(4, "good"));
  CHECK(reportIn(standard)["trust"] == "good");
  CHECK_FALSE(reportIn(standard).contains("doubt"));
  const double mu = 3000 / (2 * 1.499), K = 3000 / (3 * 0.002), l = 0.98;
  const double exact = 0.0036 * (mu * std::pow(l, -2.0 / 3) * (l - (2 + l * l) / (3 * l)) + K * (l - 1));
  CHECK(good["plate_fz_N"][3] == Approx(exact).epsilon(1e-3));

  const int code = solve(paper.scene, paper.out(), false, "", true);
  CHECK(code == 3);
  const CsvTable bad = readCsvTable(paper.out("force.csv"));
  REQUIRE(bad.trust.size() == 4);
  CHECK(bad.trust.front() == "good");
  CHECK(bad.trust.back() == "volume");
  const auto report = reportIn(paper);
  CHECK(report["trust"] == "volume");
  CHECK(report["doubt"]["first_time_s"].get<double>() > 0.25);
  CHECK_THAT(report["doubt"]["text"].get<std::string>(), Contains("pressure"));
  REQUIRE(solve(paper.scene, paper.out(), true) == 0);  // nothing left to do, and what was doubted still is
  CHECK(reportIn(paper)["trust"] == "volume");
}

TEST_CASE("probes.csv holds the displacement field of the solver", "[solve_command]") {
  const Folder folder;
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const Model model = loadModel(readScene(folder.scene));
  StaticSolver solver(model, 1, model.scene.solve.tolerance);
  for (int k = 1; k <= 4; ++k) REQUIRE(solver.advanceTo(k / 4.0).converged);
  const std::vector<Vec3> at{Vec3(0, 0, 0.015), Vec3(0.01, -0.02, 0.03), Vec3(0.0299, 0.01, 0.007)};
  const ShapeTable shape = shapeAt(model, at);
  const auto expected = fieldAt(shape, solver.body().u);
  const CsvTable table = readCsvTable(folder.out("probes.csv"));
  REQUIRE(table.rowCount() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK((Vec3(table["X"][k], table["Y"][k], table["Z"][k]) - at[k]).norm() == 0);
    CHECK((Vec3(table["ux"][k], table["uy"][k], table["uz"][k]) - expected[k]).norm() < 1e-15);  // the same run
  }
  // On the plate it goes where the plate goes, nearly: between nodes the field is free to bulge.
  CHECK(table["uz"][1] == Approx(-0.003).epsilon(0.01));
}

TEST_CASE("Probes beside a border between tissues have the field's kink there", "[solve_command]") {
  // Two layers, 1 : 10, that do not swell sideways: each is strained alike all over, the soft one ten times as much.
  std::string text = replaced(block_scene, "young = 3000\npoisson = 0.45\n", R"(young = 3000
poisson = 0
[[material]]
model = "neo-hookean"
young = 300
poisson = 0
region = { shape = "box", min = [-0.04, -0.04, 0.015], max = [0.04, 0.04, 0.04] }
)");
  text = replaced(text, "translation = [0.001, 0, -0.003]", "translation = [0, 0, -0.000003]");
  const Folder folder(text);
  std::vector<double> heights;
  std::string list = "name,X,Y,Z\n";
  for (const double z : {0.006, 0.012, 0.0145, 0.0149, 0.0151, 0.0155, 0.018, 0.025})
    for (const double x : {-0.017, -0.006, 0.002, 0.013})
      for (const double y : {-0.011, 0.001, 0.019}) {
        heights.push_back(z);
        list += "1," + std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + "\n";
      }
  folder.write("probes.csv", list);
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const CsvTable table = readCsvTable(folder.out("probes.csv"));
  REQUIRE(table.rowCount() == heights.size());
  for (std::size_t k = 0; k < heights.size(); ++k) {
    const double z = heights[k], flow = std::min(z, 0.015) + 10 * std::max(0.0, z - 0.015);
    CAPTURE(k, z);
    CHECK(table["uz"][k] == Approx(-0.000003 * flow / 0.165).epsilon(0.01));
  }
}

TEST_CASE("A scene with several tools is solved, each along its own script", "[solve_command][whole]") {
  const std::string two_tools = test::block_text + R"([[tool]]
shape = "sphere"
radius = 0.01
position = [0, 0, 0.035]
input = "script:press.toml"
[[tool]]
shape = "capsule"
radius = 0.004
length = 0.02
position = [0.02, 0, 0.045]
max_force = 1e-4
input = "script:nip.toml"
[solve]
load_steps = 2
)";
  const std::string nip = "[[keyframe]]\ntime = 0.5\nadvance = 0\n[[keyframe]]\ntime = 2\nadvance = 0.001\n";
  const Folder folder(two_tools);
  folder.write("press.toml", "[[keyframe]]\ntime = 1\nadvance = 0.002\n");
  folder.write("nip.toml", nip);
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const CsvTable force = readCsvTable(folder.out("force.csv"));
  REQUIRE(force.rowCount() == 2);
  CHECK(force["time_s"][1] == 2.0);  // where the longest script ends
  CHECK(force["tool_fz_N"][1] > 0);
  CHECK(force["tool2_fz_N"][0] < force["tool2_fz_N"][1]);
  CHECK(force["base_fz_N"][1] == Approx(force["tool_fz_N"][1] + force["tool2_fz_N"][1]).epsilon(0.02));
  const auto report = reportIn(folder);
  REQUIRE(report["tools"].size() == 2);
  CHECK(report["tools"][1]["force_N"][2].get<double>() == Approx(force["tool2_fz_N"][1]).epsilon(1e-12));
  REQUIRE(report["beyond_limit"].size() == 1);  // the first tool's is far
  CHECK(report["beyond_limit"][0]["tool"] == 2);
  CHECK(report["beyond_limit"][0]["key"] == "max_force");
  CHECK(report["beyond_limit"][0]["force_N"].get<double>() >= force["tool2_fz_N"][1]);
  REQUIRE(solve(folder.scene, folder.out(), true) == 0);  // nothing left to do
  folder.write("nip.toml", replaced(nip, "advance = 0.001", "advance = 0.002"));
  CHECK_THAT(refusal([&] { solve(folder.scene, folder.out(), true); }), Contains("another scene"));

  // Jaws need a way along which they take hold.
  const std::string jaws = replaced(two_tools, "length = 0.02\n", "length = 0.02\nopening = 0.01\n");
  folder.write("block.toml", jaws);
  CHECK_THAT(refusal([&] { solve(folder.scene, folder.out()); }), Contains("jaws") && Contains("transient"));
  folder.write("block.toml", replaced(jaws, "load_steps = 2", "mode = \"transient\"\nend_time = 0.02"));
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const CsvTable motion = readCsvTable(folder.out("force.csv"));
  CHECK(motion.rowCount() == 10);
  CHECK(motion.find("tool2_pinch_N") >= 0);
  CHECK(motion.find("tool_pinch_N") < 0);
}

TEST_CASE("A tool without a script stands in a body's way, and friction does not depend on the load steps",
          "[solve_command][whole]") {
  // The base lifts the block by 3 mm, under the tool or beside the same tool that comes down.
  const std::string raised = replaced(replaced(test::block_text, "[[fixed]]", "[[prescribed]]"), "distance = 1e-6\n",
                                      "distance = 1e-6\ntranslation = [0, 0, 0.003]\nduration = 1\n") +
                             "[tool]\nshape = \"sphere\"\nradius = 0.01\nposition = [0.01, 0, 0.0301]\n";
  const auto lastForce = [](const std::string& text, const std::string& script = "") {
    const Folder folder(text);
    if (!script.empty()) folder.write("press.toml", script);
    REQUIRE(solve(folder.scene, folder.out(), false, script.empty() ? "" : folder.path("press.toml")) == 0);
    const CsvTable force = readCsvTable(folder.out("force.csv"));
    CHECK(force["base_fz_N"].back() == Approx(force["tool_fz_N"].back()).epsilon(0.01));
    return Vec3(force["tool_fx_N"].back(), force["tool_fy_N"].back(), force["tool_fz_N"].back());
  };
  const std::string steps = "[solve]\nload_steps = 3\nend_time = 1\n";
  const Vec3 standing = lastForce(raised + steps);
  CHECK(standing.z() > 0.02);
  const std::string comes = test::block_text +
                            "[tool]\nshape = \"sphere\"\nradius = 0.01\n"
                            "position = [0.01, 0, 0.0301]\nfriction = 0.3\n";
  const std::string script = "from_touch = false\n[[keyframe]]\ntime = 1\nadvance = 0.003\n";
  const Vec3 by_three = lastForce(comes + steps, script),
             by_one = lastForce(comes + replaced(steps, "load_steps = 3", "load_steps = 1"), script);
  CHECK((standing - by_three).norm() < 0.1 * standing.norm());  // but for friction
  CHECK((by_one - by_three).norm() < 0.02 * by_three.norm());
}

TEST_CASE("A transient solution has a row a tick", "[solve_command]") {
  std::string text = replaced(block_scene, "[solve]\ntolerance = 1e-5\nload_steps = 4\n",
                              "[dynamics]\nrate = 500\n[solve]\nmode = \"transient\"\n");
  text = replaced(text, "end_time = 1", "end_time = 0.04");
  const Folder folder(text);
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const CsvTable force = readCsvTable(folder.out("force.csv"));
  CHECK(force.rowCount() == 20);
  CHECK(force["time_s"].back() == Approx(0.04).epsilon(1e-12));
  CHECK(reportIn(folder)["mode"] == "transient");
  CHECK(force["expected_force_error"].back() > 0);
  CHECK(force["expected_force_error"].back() < 1);
  // Only an equilibrium has an estimate of how far it is from rest.
  CHECK(force.find("error_m") < 0);
  CHECK_THAT(readAll(folder.out("force.csv")), !Contains("nan"));
}

TEST_CASE("Resumed after half of the load steps, a solution ends where an unbroken one does",
          "[solve_command][checkpoint][whole]") {
  const Folder whole;
  REQUIRE(solve(whole.scene, whole.out()) == 0);
  // The first half as a run of its own: the same model, steps and times.
  const Folder broken(
      replaced(replaced(block_scene, "load_steps = 4", "load_steps = 2"), "end_time = 1", "end_time = 0.5"));
  REQUIRE(solve(broken.scene, broken.out()) == 0);
  const CsvTable half = readCsvTable(broken.out("force.csv"));
  broken.write("block.toml", block_scene);
  REQUIRE(solve(broken.scene, broken.out(), true) == 0);

  const CsvTable a = readCsvTable(whole.out("force.csv")), b = readCsvTable(broken.out("force.csv"));
  REQUIRE(b.rowCount() == 4);
  CHECK(b.name == a.name);
  for (std::size_t r = 0; r < 4; ++r) {
    CHECK(b["time_s"][r] == Approx(a["time_s"][r]).epsilon(1e-12));
    CHECK(b["plate_fz_N"][r] ==
          Approx(a["plate_fz_N"][r]).epsilon(1e-3));  // tolerance 1e-5 of u, times the bulk stiffness
  }
  for (std::size_t r = 0; r < 2; ++r) CHECK(b["plate_fz_N"][r] == half["plate_fz_N"][r]);  // kept as they were
  const CsvTable u = readCsvTable(whole.out("probes.csv")), v = readCsvTable(broken.out("probes.csv"));
  for (std::size_t k = 0; k < u.rowCount(); ++k) CHECK(v["uz"][k] == Approx(u["uz"][k]).margin(3 * 1e-5 * 0.01));

  // Once done there is nothing left to do.
  REQUIRE(solve(broken.scene, broken.out(), true) == 0);
  CHECK(readCsvTable(broken.out("force.csv")).rowCount() == 4);
}

TEST_CASE("Interrupted by a signal, the command says so and can be resumed", "[solve_command][checkpoint]") {
  const Folder folder;
  // Once the set-up is done and the solution has begun.
  CHECK(test::codeWhenInterrupted(folder.out("force.csv"), [&] { return solve(folder.scene, folder.out()); }) == 1);
  CHECK(reportIn(folder)["interrupted"] == true);
  CHECK(reportIn(folder)["rows"] < 4);
  REQUIRE(solve(folder.scene, folder.out(), true) == 0);
  const Folder whole;
  REQUIRE(solve(whole.scene, whole.out()) == 0);
  const CsvTable a = readCsvTable(whole.out("force.csv")), b = readCsvTable(folder.out("force.csv"));
  REQUIRE(b.rowCount() == 4);
  CHECK(b["plate_fz_N"][3] == Approx(a["plate_fz_N"][3]).epsilon(1e-3));
}

TEST_CASE("Interrupted during the set-up, the command ends with nothing to keep", "[solve_command]") {
  const Folder folder;
  const int code = test::exitCodeOfChild([&] {
    catchInterrupts();
    std::raise(SIGINT);
    try {
      return solve(folder.scene, folder.out());
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).find("while the model was made") != std::string::npos ? 1 : 98;
    }
  });
  CHECK(code == 1);
  CHECK_FALSE(std::filesystem::exists(folder.out("force.csv")));
}

TEST_CASE("A checkpoint that can't be gone on from is refused", "[solve_command][checkpoint][whole]") {
  const Folder folder;
  CHECK_THROWS_AS(solve(folder.scene, folder.out(), true), InputError);  // there is none yet
  CHECK_THAT(refusal([&] { solve(folder.scene, folder.out(), true); }), Contains("there is no checkpoint"));
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const std::string good = readAll(folder.out("checkpoint.bin"));
  const auto resumed = [&] { return refusal([&] { solve(folder.scene, folder.out(), true); }); };

  std::string bad = good;
  bad[good.size() / 2] = static_cast<char>(bad[good.size() / 2] ^ 1);
  for (const std::string& bytes :
       {bad, good.substr(0, good.size() - 1), good.substr(0, 20), std::string(), good + "x"}) {
    folder.write("out/checkpoint.bin", bytes);
    CHECK_THAT(resumed(), Contains("checkpoint.bin") && Contains("damaged") && Contains("--resume"));
  }
  folder.write("out/checkpoint.bin", good);

  const auto with = [&](const std::string& what, const std::string& instead) {
    folder.write("block.toml", replaced(block_scene, what, instead));
    const std::string message = resumed();
    folder.write("block.toml", block_scene);
    return message;
  };
  CHECK_THAT(with("young = 3000", "young = 4000"), Contains("another scene"));
  CHECK_THAT(with("spacing = 0.012", "spacing = 0.014"), Contains("another scene"));
  CHECK_THAT(with("load_steps = 4", "load_steps = 8"), Contains("load_steps"));  // position 4 would be half the load
  CHECK_THAT(with("end_time = 1", "end_time = 2"), Contains("end_time"));
  CHECK_THAT(with("name = \"plate\"", "name = \"punch\""), Contains("force.csv") && Contains("does not belong"));

  const CsvTable force = readCsvTable(folder.out("force.csv"));
  CHECK(force.rowCount() == 4);  // what was refused has changed nothing
  std::filesystem::remove(folder.out("force.csv"));
  CHECK_THROWS_AS(solve(folder.scene, folder.out(), true), InputError);
}

TEST_CASE("A checkpoint is read back as it was written", "[checkpoint]") {
  const TempFolder folder;
  Checkpoint c;
  c.model_hash = 0x123456789abcdefull;
  c.position = 7;
  c.rows = 6;
  c.frame_time = {0.25, 0.5};
  for (int i = 0; i < 5; ++i) {
    c.u.push_back({0.1 * i, -1.0 / 3, 1e-300, 0});
    c.du.push_back({1e-9 * i, -5e-324, -0.0, 0});
  }
  c.history = {1, -2.5, 1e-300};
  const std::string path = folder.path("checkpoint.bin");
  writeCheckpoint(path, c);
  const Checkpoint d = readCheckpoint(path, c.model_hash, 5);
  CHECK(d.position == 7);
  CHECK(d.rows == 6);
  CHECK(d.frame_time == c.frame_time);
  CHECK(d.history == c.history);
  CHECK(std::memcmp(d.u.data(), c.u.data(), 5 * sizeof(Double4)) == 0);
  CHECK(std::memcmp(d.du.data(), c.du.data(), 5 * sizeof(Double4)) == 0);
  CHECK_THAT(refusal([&] { readCheckpoint(path, c.model_hash + 1, 5); }), Contains("another scene"));
  CHECK_THAT(refusal([&] { readCheckpoint(path, c.model_hash, 6); }), Contains("another scene"));
}

TEST_CASE("A forged checkpoint with a checksum that holds is refused", "[checkpoint]") {
  const TempFolder folder;
  const std::string path = folder.path("checkpoint.bin");
  Checkpoint good;
  good.position = 2;
  good.rows = 1;
  good.frame_time = {0.5};
  good.u.resize(3);
  good.du.resize(3);
  writeCheckpoint(path, good);
  CHECK(readCheckpoint(path, 0, 3).rows == 1);
  const auto refused = [&] {
    CHECK_THAT(refusal([&] { readCheckpoint(path, 0, 3); }), Contains("checkpoint.bin: the checkpoint is damaged"));
  };
  const auto with = [&](auto&& change) {
    Checkpoint c = good;
    change(c);
    writeCheckpoint(path, c);
    refused();
  };
  with([](Checkpoint& c) { c.rows = -1; });
  with([](Checkpoint& c) { c.rows = 3; });  // more than steps
  with([](Checkpoint& c) { c.position = c.rows = -5; });
  with([](Checkpoint& c) { c.position = std::int64_t{1} << 62; });
  with([](Checkpoint& c) { c.largest = -1; });
  with([](Checkpoint& c) { c.largest = NAN; });
  with([](Checkpoint& c) { c.frame_time = {1, 0.5}; });
  with([](Checkpoint& c) { c.frame_time = {INFINITY}; });
  with([](Checkpoint& c) { c.frame_time = {-1}; });
  with([](Checkpoint& c) { c.u[1].y = INFINITY; });
  with([](Checkpoint& c) { c.du[2].z = NAN; });
  with([](Checkpoint& c) { c.history = {NAN}; });

  // 2^61 more frames, 2^58 more nodes or 2^61 more numbers of history take no more bytes, counted modulo 2^64.
  writeCheckpoint(path, good);
  const std::string bytes = readAll(path);
  const std::size_t frames = bytes.find('\n') + 1 + 4 * 8;
  for (const auto& [offset, byte] :
       {std::pair<std::size_t, char>{frames, '\x20'}, {frames + 8, '\x04'}, {frames + 16, '\x20'}}) {
    std::string forged = bytes.substr(0, bytes.size() - 8);
    forged[offset + 7] = byte;
    const std::uint64_t sum = fnv1a(forged);
    forged.append(reinterpret_cast<const char*>(&sum), sizeof sum);
    folder.write("checkpoint.bin", forged);
    refused();
  }
}

TEST_CASE("A boundary with blanks in its name can be resumed", "[solve_command][checkpoint]") {
  const Folder folder(replaced(block_scene, "name = \"plate\"", "name = \"upper  plate #1\""));
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  CHECK(solve(folder.scene, folder.out(), true) == 0);
}

TEST_CASE("A scene file whose name is not UTF-8 is solved and reported", "[solve_command]") {
  const Folder folder;
  const std::string unnamed = replaced(block_scene, "name = \"block\"\n", "");
  const std::string scene = folder.write("block \xff\n.toml", unnamed);
  REQUIRE(solve(scene, folder.out()) == 0);
  CHECK(reportIn(folder)["scene"] == "block ??");
}

TEST_CASE("A folder that can't be made is an error of the system, with its name", "[solve_command]") {
  const Folder folder;
  folder.write("blocked", "a file stands here");
  CHECK_THROWS_WITH(solve(folder.scene, folder.path("blocked") + "/sub"), Contains("blocked"));
  bool system = false;
  try {
    solve(folder.scene, folder.path("blocked") + "/sub");
  } catch (const InputError&) {
  } catch (const std::runtime_error&) {
    system = true;
  }
  CHECK(system);
}

TEST_CASE("Scenes that can't be solved are refused with what is missing", "[solve_command]") {
  const auto refused = [](const std::string& text) {
    const Folder folder(text);
    return refusal([&] { solve(folder.scene, folder.out()); });
  };
  const std::string without_end = replaced(block_scene, "end_time = 1\n", "");
  const std::size_t from = without_end.find("[[prescribed]]"), to = without_end.find("[solve]");
  std::string still = without_end;
  still.erase(from, to - from);
  CHECK_THAT(refused(still), Contains("block.toml") && Contains("nothing moves") && Contains("[[prescribed]]"));

  const Folder folder;
  folder.write("probes.csv", probes + "4,0.5,0,0\n");
  CHECK_THAT(refusal([&] { solve(folder.scene, folder.out()); }),
             Contains("probes.csv:5") && Contains("outside the body"));
  CHECK_THROWS_AS(solve(folder.path("absent.toml"), folder.out()), InputError);
  CHECK_THROWS_AS(solve(folder.scene, folder.out(), false, folder.path("absent_script.toml")), InputError);
}

TEST_CASE("A motion too long to be written, or shorter than a tick, is not passed over in silence", "[solve_command]") {
  const std::string transient = replaced(block_scene, "[solve]\ntolerance = 1e-5\nload_steps = 4\n",
                                         "[dynamics]\nrate = 500\n[solve]\nmode = \"transient\"\n");
  for (const char* end : {"end_time = 1e300", "end_time = 1e6"}) {
    const Folder folder(replaced(transient, "end_time = 1", end));
    CHECK_THAT(refusal([&] { solve(folder.scene, folder.out()); }),
               Contains("block.toml:30:1") && Contains("ticks") && Contains("2e+05 s; lower end_time"));
    CHECK_FALSE(std::filesystem::exists(folder.out("force.csv")));
  }
  const Folder folder(replaced(transient, "end_time = 1", "end_time = 1e-12"));
  CHECK(solve(folder.scene, folder.out()) == 0);
  CHECK(readCsvTable(folder.out("force.csv")).rowCount() == 1);
}

TEST_CASE("A refused run leaves an earlier run's results as they are", "[solve_command]") {
  const Folder folder;
  REQUIRE(solve(folder.scene, folder.out()) == 0);
  const std::string force = readAll(folder.out("force.csv")), checkpoint = readAll(folder.out("checkpoint.bin"));
  folder.write("block.toml", replaced(block_scene, "spacing = 0.012", "spacing = 1e-5"));
  CHECK_THROWS_AS(solve(folder.scene, folder.out()), InputError);
  folder.write("block.toml", replaced(block_scene, "name = \"plate\"", "name = \"a,b\""));
  CHECK_THROWS(solve(folder.scene, folder.out()));  // no name for a column
  CHECK(readAll(folder.out("force.csv")) == force);
  CHECK(readAll(folder.out("checkpoint.bin")) == checkpoint);
  CHECK_FALSE(std::filesystem::exists(folder.out("force.csv.part")));
}

TEST_CASE("A load that nothing can bear ends with code 1 and a report that says so", "[solve_command][whole]") {
  const Folder folder(
      replaced(replaced(block_scene, "translation = [0.001, 0, -0.003]", "translation = [0, 0, -0.045]"),
               "load_steps = 4", "load_steps = 1"));
  CHECK(solve(folder.scene, folder.out()) == 1);
  CHECK(reportIn(folder)["diverged"] == true);
  CHECK(reportIn(folder)["converged"] == false);
  CHECK_THAT(readAll(folder.out("probes.csv")), !Contains("nan"));
}

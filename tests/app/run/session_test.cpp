#include "app/run/session.h"

#include <sys/resource.h>

#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>
#include <utility>

#include "app/run/run_files.h"
#include "io/certificate.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "support/block_text.h"
#include "support/captured_output.h"
#include "support/realtime_guard.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// As it goes by itself, to its end.
void runThrough(Session& session) {
  session.start();
  while (!session.finished()) {
    session.gather();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  session.finish();
}

/// Two points of a body with three nodes whose gradients reproduce linear fields exactly:
/// sum gradN = 0, sum X (x) gradN restricted to the xz-plane's two directions.
Model twoPoints() {
  Model model;
  model.X = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  model.point_X = {{0.2, 0, 0.2}, {0.4, 0, 0.4}};
  model.point_volume = {1e-6, 3e-6};
  model.point_shape.begin = {0, 3, 6};
  model.point_shape.node = {0, 1, 2, 0, 1, 2};
  for (int q = 0; q < 2; ++q) {
    model.point_shape.gradN.emplace_back(-1, 0, -1);
    model.point_shape.gradN.emplace_back(1, 0, 0);
    model.point_shape.gradN.emplace_back(0, 0, 1);
  }
  return model;
}

}  // namespace

TEST_CASE("The volume's change is that of the deformation gradient", "[session]") {
  const Model model = twoPoints();
  AlignedVector<Float4> u(3);
  CHECK(volumeChange(model, u.data()) == 0);
  u[1].x = 0.10F;   // stretch of 10 % along x,
  u[2].z = -0.05F;  // 5 % shorter along z: J = 1.1 * 0.95
  CHECK(volumeChange(model, u.data()) == Approx(1.1 * 0.95 - 1).epsilon(1e-6));
  for (Float4& a : u) a.y += 3;  // a translation changes nothing
  CHECK(volumeChange(model, u.data()) == Approx(1.1 * 0.95 - 1).epsilon(1e-6));
}

TEST_CASE("A stiffer material's stress is in proportion, its Poisson's ratio and density stay", "[session]") {
  const Material soft = Material::neoHookean(3000, 0.49, 1060);
  const Material half = stiffened(soft, 0.5);
  Mat3 F = Mat3::Identity();
  F(0, 1) = 0.2;
  F(2, 2) = 0.9;
  CHECK((half.firstPiola(F) - 0.5 * soft.firstPiola(F)).norm() < 1e-12 * soft.firstPiola(F).norm());
  CHECK(half.density == soft.density);

  const double mu[] = {1000, 500}, alpha[] = {2, -2};
  const Material ogden = Material::ogden(mu, alpha, 2, 1e-5, 1000);
  CHECK((stiffened(ogden, 2).firstPiola(F) - 2 * ogden.firstPiola(F)).norm() < 1e-9 * ogden.firstPiola(F).norm());
}

TEST_CASE("The default indentation goes from the start pose by the touch into the tissue and stays", "[session]") {
  Model model;
  model.scene.dynamics.rate_hz = 500;
  model.scene.tools[0].shape.radius = 0.01;
  model.skin.surface.vertices = {{0, 0, 0}, {0, 0, 0.08}};
  model.tools.first().start.pose.position = {0, 0, 0.1};
  model.tools.first().first_contact_travel = 0.02;
  const std::vector<ToolPosture> way = scriptWay(indentScript(model), model);
  const double depth = 0.012;  // 1.2 radii; a quarter of the height would be 20 mm
  CHECK(way.back().pose.position.z() == Approx(0.08 - depth).epsilon(1e-9));
  double last = 0.1;
  double fastest = 0;
  for (const ToolPosture& at : way) {
    CHECK(at.pose.position.z() <= last + 1e-12);  // never back
    fastest = std::max(fastest, (last - at.pose.position.z()) * 500);
    last = at.pose.position.z();
  }
  CHECK(fastest < 0.2);  // m/s; 1.875 times the mean of the approach, at most
}

TEST_CASE("force.csv has the agreed header, a row per sample, and numbers that read back exactly", "[session]") {
  const std::string folder = std::string(PALPATE_BINARY_DIR) + "/result_folder_test/nested";
  std::filesystem::remove_all(folder);
  ResultFolder results(folder);
  Model model;
  model.rigid.body.emplace_back().name = "floor";
  results.begin(ForceColumns(model));
  ForceSample sample;
  sample.rigid_force[0][2] = 1.5F;
  sample.time_s = 0.002;
  sample.depth_m = -0.0123456789;
  sample.advance_m = 0.25;
  sample.force_raw = {1, 2.5, -3e-7};
  sample.force_filtered = {0.5, 0, 1.0 / 3};
  sample.tool_pose.position = {0.125, -0.25, 1.0 / 7};
  sample.torque = {-1e-5, 0, 2.0 / 3};
  sample.contact_count = 17;
  sample.expected_error = 0.03125;
  results.addForce(sample);
  results.finishForces();
  std::istringstream lines(readAll(results.forceFile()));
  std::string header, row, rest;
  std::getline(lines, header);
  std::getline(lines, row);
  CHECK(header ==
        "time_s,depth_m,advance_m,force_raw_N_x,force_raw_N_y,force_raw_N_z,"
        "force_filtered_N_x,force_filtered_N_y,force_filtered_N_z,trust,"
        "tool_x_m,tool_y_m,tool_z_m,tool_qx,tool_qy,tool_qz,tool_qw,torque_Nm_x,torque_Nm_y,torque_Nm_z,contacts,"
        "expected_error,floor_force_N_x,floor_force_N_y,floor_force_N_z");
  double value[9] = {};
  char comma = 0;
  std::istringstream cells(row);
  for (double& v : value) cells >> v >> comma;
  CHECK(value[0] == 0.002);
  CHECK(value[1] == Approx(-0.0123456789).epsilon(1e-8));
  CHECK(value[2] == 0.25);
  CHECK(value[5] == -3e-7);
  CHECK(value[8] == Approx(1.0 / 3).epsilon(1e-8));
  CHECK(row.ends_with(",good,0.125,-0.25,0.142857143,0,0,0,1,-1e-05,0,0.666666667,17,0.0312,0,0,1.5"));
  CHECK_FALSE(std::getline(lines, rest));
  results.writeReport("{}");
  CHECK(readAll(results.reportFile()) == "{}\n");
  std::filesystem::remove_all(folder);
}

TEST_CASE("A folder that can't be written is refused with its name and the reason", "[session]") {
  const auto message = [](const std::string& folder) -> std::string {
    try {
      ResultFolder results(folder);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(message("/proc/palpate").find("/proc/palpate") != std::string::npos);
  CHECK(message("/dev/null/x").find("Not a directory") != std::string::npos);

  // A full disk: /dev/full takes the file but not the rows.
  const std::string folder = std::string(PALPATE_BINARY_DIR) + "/full_disk_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  std::filesystem::create_symlink("/dev/full", folder + "/force.csv.part");
  CHECK(message(folder).find("No space left on device") != std::string::npos);
  std::filesystem::remove_all(folder);
}

TEST_CASE("A run that is refused takes nothing of an earlier one's results away", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  options.as_fast_as_possible = true;
  options.seconds = 0.01;
  options.out = folder.path("out");
  std::filesystem::create_directories(options.out);
  folder.write("out/force.csv", "earlier\n");
  const auto files = [&] {
    return std::distance(std::filesystem::directory_iterator(options.out), std::filesystem::directory_iterator());
  };
  Log log;
  // The tool inside the organ: found when everything else is made.
  options.scene = folder.write("inside.toml", replaced(test::touched_block_text, "0, 0, 0.035", "0, 0, 0.02"));
  CHECK_THAT(refusal([&] { Session(options, app::readScene(options), log); }), Catch::Contains("inside the organ"));
  CHECK(readAll(folder.path("out/force.csv")) == "earlier\n");
  CHECK(files() == 1);

  // Accepted, but never started: no display, say.
  options.scene = folder.write("block.toml", test::touched_block_text);
  Session(options, app::readScene(options), log);
  CHECK(readAll(folder.path("out/force.csv")) == "earlier\n");
  CHECK(files() == 1);

  Session session(options, app::readScene(options), log);
  runThrough(session);
  const std::string force = readAll(folder.path("out/force.csv"));
  CHECK(std::count(force.begin(), force.end(), '\n') == 1 + 5);
  CHECK(files() == 1);
}

TEST_CASE("Off-screen a scene's own script is played to its end, and no two pictures are of one tick", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  const std::string script = folder.write("long.toml",
                                          "[[keyframe]]\ntime = 0.5\nadvance = 0\n"
                                          "[[keyframe]]\ntime = 4.5\nadvance = 0.001\n");
  options.scene = folder.write(
      "block.toml", replaced(test::touched_block_text, "[tool]\n", "[tool]\ninput = \"script:" + script + "\"\n"));
  options.out = folder.path("out");
  Log log;
  Session session(options, app::readScene(options), log);
  runThrough(session);
  CHECK(session.report().ticks == 2250 + 10);  // with the last corner's rounding

  options.snapshot_at = {0.4, 0.4005};
  CHECK_THAT(refusal([&] { Session(options, app::readScene(options), log); }), Catch::Contains("one tick"));
  options.snapshot_at = {0.4, 0.402};
  Session(options, app::readScene(options), log);
}

TEST_CASE("A recording that can't be replayed is found before the set-up is made", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  // A scene that is refused when everything else is made, so that what is said shows what came first.
  options.scene = folder.write("inside.toml", replaced(test::touched_block_text, "0, 0, 0.035", "0, 0, 0.02"));
  options.out = folder.path("out");
  Log log;
  const auto message = [&] { return refusal([&] { Session(options, app::readScene(options), log); }); };
  options.replay = folder.path("absent.rec");
  CHECK_THAT(message(), Catch::Contains("absent.rec"));
  options.replay =
      folder.write("slow.rec", "palpate-recording 3\nscene block\nmodel 0123456789abcdef\nrate_hz 250\nend 5\n");
  CHECK_THAT(message(), Catch::Contains("slow.rec:4") && Catch::Contains("--rate 250"));
  options.replay.clear();
  options.tool_script = folder.path("absent.toml");
  CHECK_THAT(message(), Catch::Contains("absent.toml"));
  CHECK_FALSE(std::filesystem::exists(options.out));
}

TEST_CASE("A scripted run is repeated by its recording, bit for bit", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  options.tool_script = folder.write("press.toml",
                                     "[[keyframe]]\ntime = 0.05\nadvance = 0\n"
                                     "[[keyframe]]\ntime = 0.15\nadvance = 0.003\n");
  options.record = folder.path("press.rec");
  Log log;
  const auto hashOf = [&] {
    Session session(options, app::readScene(options), log);
    runThrough(session);
    CHECK(session.failure().empty());
    return session.report().state_hash;
  };
  const auto scripted = hashOf();
  options.tool_script.clear();
  options.replay = std::exchange(options.record, "");
  CHECK(hashOf() == scripted);
  const Recording recording = readRecording(options.replay);
  CHECK(recording.ticks == 75 + 10);  // 0.15 s, and the last corner's rounding
  CHECK(recording.changes.size() > 50);
}

TEST_CASE("Forces that find no room are told, and the recording is written all the same", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  options.seconds = 0.1;
  options.record = folder.path("run.rec");
  const int code = test::exitCodeOfChild([&] {  // whose files hold no more
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit few_bytes{3000, 3000};
    setrlimit(RLIMIT_FSIZE, &few_bytes);
    Log log;
    Session session(options, app::readScene(options), log);
    runThrough(session);
    return session.failure().find("force.csv: File too large") == std::string::npos ? 1 : 0;
  });
  CHECK(code == 0);
  CHECK(std::filesystem::file_size(folder.path("out/force.csv")) == 3000);
  CHECK(readRecording(options.record).ticks == 50);
}

TEST_CASE("Files that can't be written are refused before the set-up is made", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  Log log;
  for (std::string Options::*file : {&Options::record, &Options::animation, &Options::export_file}) {
    Options wrong = options;
    wrong.*file = folder.path("");
    CHECK_THROWS_WITH(Session(wrong, app::readScene(wrong), log),
                      Catch::Contains("Is a directory; choose another file with --"));
    CHECK_FALSE(std::filesystem::exists(options.out));
    wrong.*file = folder.path("out/made");  // beside the results, in a folder that comes with them
    CHECK_NOTHROW(Session(wrong, app::readScene(wrong), log));
    std::filesystem::remove_all(options.out);
  }
}

TEST_CASE("What a run reads, or writes already, it does not overwrite", "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  const auto refused = [&](std::string Options::*output, const std::string& name, const char* why) {
    Options wrong = options;
    wrong.*output = folder.path(name);
    const std::string scene = readAll(options.scene);
    CHECK_THROWS_WITH(openResults(wrong, app::readScene(wrong)), Catch::Contains(why));
    CHECK(readAll(options.scene) == scene);
    CHECK_FALSE(std::filesystem::exists(options.out));
  };
  refused(&Options::record, "block.toml", "--record would overwrite it, and the scene reads it");
  refused(&Options::animation, "out/../block.toml", "--animation would overwrite it");
  refused(&Options::record, "out/report.json", "both --record and --out would write it");
  refused(&Options::compare, "out/snapshot.png", "--out would overwrite it, and --compare reads it");
  options.record = folder.path("a.rec");
  refused(&Options::export_file, "./a.rec", "both --record and --export would write it");
  options.tool_script = folder.write("press.toml", "name = \"p\"\n[[keyframe]]\ntime = 0.1\nadvance = 0.001\n");
  refused(&Options::record, "press.toml", "--tool reads it");
}

TEST_CASE("The score sheet of another trainee is not overwritten, and one's own is not left to another run",
          "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  options.trainee_name = "Anna";
  openResults(options, app::readScene(options));
  const std::string sheet = folder.write(
      "out/score.json",
      R"({"kind": "palpate score", "trainee": "Anna", "hits": 1, "misses": 0, "false_alarms": 0, "conditions": {}})");
  folder.write("out/score.png", "");
  options.trainee_name = "Ben";
  CHECK_THROWS_WITH(openResults(options, app::readScene(options)),
                    Catch::Contains("the score sheet of Anna lies there; name another folder with --out"));
  CHECK(std::filesystem::exists(sheet));
  options.trainee_name = "Anna";
  auto results = openResults(options, app::readScene(options));
  CHECK(std::filesystem::exists(sheet));  // the run may yet be refused
  results->begin();
  CHECK_FALSE(std::filesystem::exists(sheet));
  CHECK_FALSE(std::filesystem::exists(folder.path("out/score.png")));
}

TEST_CASE("A run in real time leaves a core to others where nothing is said of threads", "[session]") {
  const TempFolder folder;
  Options options;
  options.scene = folder.write("block.toml", test::block_text);
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  CHECK(app::readScene(options).dynamics.threads == std::clamp(cores - 1, 1, 2));
  options.threads = 3;
  CHECK(app::readScene(options).dynamics.threads == 3);
  options.threads.reset();
  options.as_fast_as_possible = true;
  CHECK(app::readScene(options).dynamics.threads == 1);
  options.as_fast_as_possible = false;
  options.scene = folder.write("said.toml", std::string(test::block_text) + "[dynamics]\nthreads = 1\n");
  CHECK(app::readScene(options).dynamics.threads == 1);
}

TEST_CASE("Without lumps there is nothing for a trainee to find", "[session]") {
  const TempFolder folder;
  Options options;
  options.scene = folder.write("block.toml", test::block_text);
  CHECK(app::readScene(options).discretization.spacing == 0.012);
  for (bool Options::*wish : {&Options::trainee, &Options::check_lumps, &Options::answers}) {
    Options wishful = options;
    wishful.*wish = true;
    CHECK_THAT(refusal([&] { app::readScene(wishful); }), Catch::Contains("block.toml") && Catch::Contains("no lumps"));
  }
}

namespace {

struct Searched {
  std::string score;
  Conditions conditions;
  bool revealed = false;
};

Searched searched(const Options& options, Log& log) {
  Session session(options, app::readScene(options), log);
  CHECK(session.searching());
  runThrough(session);
  CHECK(session.failure().empty());
  return {session.task()->json({}, "") + session.task()->pressureCsv(), session.conditions(), session.revealed()};
}

}  // namespace

TEST_CASE("A search's recording brings marks and answers: a replay scores the same and is shut until then",
          "[session][whole]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  options.scene = folder.write("block.toml", test::lump_block_text);
  options.out = folder.path("out");
  options.trainee = true;
  options.record = folder.path("search.rec");
  Log log;
  const Searched first = searched(options, log);
  CHECK(first.revealed);
  CHECK(first.conditions.moved_by == "a trainee by rule");
  CHECK(first.score.find("\"marks\":[{") != std::string::npos);

  options.trainee = false;
  options.replay = std::exchange(options.record, "");
  options.picture.ghost = true;  // from the answers on
  const Searched again = searched(options, log);
  CHECK(again.revealed);
  CHECK(again.score == first.score);
  CHECK(again.conditions.moved_by == "the recording search.rec");
  CHECK(again.conditions.changes.empty());

  // Never submitted: it stays shut, and what would show the inside is refused.
  const std::string text = readAll(options.replay);
  const std::size_t at = text.rfind('\n', text.find(" submit"));
  const std::size_t end = text.find('\n', at + 1);
  options.replay = folder.write("open.rec", text.substr(0, at) + text.substr(end));
  CHECK_THAT(refusal([&] { Session(options, app::readScene(options), log); }), Catch::Contains("search for lumps"));
  options.picture.ghost = false;
  const Searched open = searched(options, log);
  CHECK_FALSE(open.revealed);
  CHECK(open.score == first.score);  // the marks are there

  // A recording may bring other conditions; the sheet says so.
  const std::size_t body = text.find('\n', text.find("rate_hz")) + 1;
  options.replay = folder.write("slippery.rec", text.substr(0, body) + "0 friction 0.9\n" + text.substr(body));
  const Searched changed = searched(options, log);
  REQUIRE(changed.conditions.changes.size() == 1);
  CHECK_THAT(changed.conditions.changes[0], Catch::Contains("friction is now 0.9"));
}

TEST_CASE("Off-screen, too, nothing shows a search's inside - --answers shows it without a search",
          "[session][whole]") {
  const TempFolder folder;
  Options options;
  options.offscreen = true;
  options.scene = folder.write("block.toml", test::lump_block_text);
  const auto refused = [&](auto&& wish) {
    Options wishful = options;
    wish(wishful);
    CHECK_THAT(refusal([&] { checkOptions(wishful); }), Catch::Contains("search for lumps"));
    wishful.answers = true;
    CHECK_NOTHROW(checkOptions(wishful));
  };
  refused([](Options& o) { o.picture.ghost = true; });
  refused([](Options& o) { o.picture.cut = true; });
  refused([](Options& o) { o.picture.field = ColourMap::VonMises; });
  refused([](Options& o) { o.picture.field = ColourMap::J; });
  refused([](Options& o) { o.picture.show = "contact,nodes"; });
  refused([](Options& o) { o.picture.show = "points"; });
  refused([](Options& o) { o.dump_fields = true; });
  refused([](Options& o) { o.export_file = "run.pvd"; });
  options.picture.field = ColourMap::Displacement;  // of the skin
  CHECK_NOTHROW(checkOptions(options));
  options.answers = true;
  options.out = folder.path("out");
  Log log;
  const Session session(options, app::readScene(options), log);
  CHECK_FALSE(session.searching());
  CHECK(session.answersShown());
}

TEST_CASE("What happened in the run has the run's time in the log, all else none", "[session]") {
  const CapturedOutput printed;
  Log log;
  log.info("made");
  log.info("made");
  log.add(LogLevel::Info, 1.5, "late", "1.500 s: late, and why");
  log.info("made");
  REQUIRE(log.lines().size() == 3);
  CHECK(log.lines()[0].text == "made (2 times)");
  CHECK_FALSE(log.lines()[0].run_s);
  CHECK(log.lines()[1].run_s == 1.5);
  CHECK(log.lines()[1].text == "late");
  CHECK(log.lines()[2].text == "made");
}

TEST_CASE("A certificate is shown where it was pressed, and hushes the warning of coarse nodes where errors are small",
          "[session]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.out = folder.path("out");
  Certificate certificate;
  certificate.model_hash = modelHash(loadModel(palpate::readScene(options.scene)));
  certificate.way = {{Vec3(0, 0, 0.031), Quat::Identity()}, {Vec3(0, 0, 0.026), Quat::Identity()}};
  certificate.row = {{0.004, 0.1, 0.1, 0.02, 0.01}};
  const CapturedOutput printed;
  const auto certifiedAfter = [&](const std::string& slide) {
    writeCertificate(certificateFile(options.scene), certificate);
    options.tool_script = folder.write("press.toml", "[[keyframe]]\ntime = 0.1\nadvance = -0.001\n" + slide +
                                                         "[[keyframe]]\ntime = 0.2\nadvance = 0.003\n" + slide);
    Log log;
    Session session(options, app::readScene(options), log);
    runThrough(session);
    const PanelData data = session.panelData(session.latest());
    CHECK(data.certified_error == Approx(data.certified.empty() ? 0 : 0.03));
    std::string lines;
    for (const LogLine& line : log.lines()) lines += line.text + "\n";
    return std::pair(data.certified, lines);
  };
  const auto [here, lines] = certifiedAfter("");
  CHECK(here == "±3 % (certified to 4 mm)");
  CHECK_THAT(lines, Catch::Contains("±3 % of it at 4 mm") && !Catch::Contains("coarse for what touches"));
  certificate.row[0].error = 0.2;
  const auto [away, warned] = certifiedAfter("slide = [0.015, 0]\n");
  CHECK(away.empty());
  CHECK_THAT(warned, Catch::Contains("±21 %") && Catch::Contains("coarse for what touches"));
  certificate.model_hash += 1;
  const auto [none, why] = certifiedAfter("");
  CHECK(none.empty());
  CHECK_THAT(why, Catch::Contains("block.certificate.json is not used"));
}

TEST_CASE("All that a picture shows is of one tick, however seldom and slowly pictures are drawn", "[session]") {
  const TempFolder folder;
  Options options;
  options.as_fast_as_possible = true;  // a picture then lasts hundreds of ticks
  options.scene = folder.write("block.toml", test::touched_block_text);
  options.tool_script = folder.write("press.toml",
                                     "[[keyframe]]\ntime = 0.05\nadvance = 0\n"
                                     "[[keyframe]]\ntime = 40\nadvance = 0.006\n");
  const CapturedOutput printed;
  Log log;
  Session session(options, app::readScene(options), log);
  session.start();
  session.send(Request::simple(Request::Kind::Resume));
  constexpr auto drawing = std::chrono::milliseconds(15);
  Snapshot early;
  bool was_reset = false;
  int pressed = 0, pressed_again = 0;  // pictures, before and after the reset
  for (int picture = 0; picture < 4000 && pressed_again < 6; ++picture) {
    if (pressed == 6 && !std::exchange(was_reset, true)) session.send(Request::simple(Request::Kind::Reset));
    std::this_thread::sleep_for(drawing);
    session.gather();
    const Snapshot& shown = session.latest();
    std::this_thread::sleep_for(drawing);
    const PanelData data = session.panelData(shown);
    REQUIRE(data.force.sample.tick == shown.force.tick);
    CHECK(data.force.sample.force_filtered == shown.force.force_filtered);
    CHECK(data.force.sample.depth_m == shown.force.depth_m);
    if (shown.force.tick <= shown.status.reset_tick) continue;
    if (!shown.force.force_raw.isZero(0)) ++(shown.status.reset_tick > 0 ? pressed_again : pressed);
    CHECK(session.samples().back().tick == shown.force.tick);
    REQUIRE_FALSE(data.forces.filteredOverTime().empty());
    CHECK(data.forces.lastTime() == shown.force.time_s);
    CHECK(data.forces.filteredOverTime().back().y == Approx(shown.force.force_filtered.norm()).epsilon(1e-6));
    CHECK(data.forces.rawOverDepth().back().x == Approx(1e3 * shown.force.depth_m).epsilon(1e-6));
    CHECK(data.forces.peakRaw() >= shown.force.force_raw.norm());
    if (pressed == 3) early = shown;
  }
  CHECK(pressed_again == 6);
  CHECK(session.latest().status.reset_tick > early.force.tick);
  // The past shows its own curves, of before the reset.
  const ForceHistory past = session.forcesUntil(early);
  CHECK(past.lastTime() == early.force.time_s);
  CHECK(past.filteredOverTime().back().y == Approx(early.force.force_filtered.norm()).epsilon(1e-6));
  session.finish();
  CHECK(session.samples().back().tick == session.latest().status.ticks);
}

TEST_CASE("app: a run on a cloud that follows the probe is repeated by its recording, and says how it followed",
          "[session][whole]") {
  const TempFolder folder;
  Options options;
  options.offscreen = options.as_fast_as_possible = true;
  options.use_cache = false;
  options.scene =
      folder.write("bar.toml", replaced(replaced(test::touched_block_text, "spacing = 0.012", "follow = true"),
                                        "size = [0.06, 0.06, 0.03]", "size = [0.12, 0.04, 0.03]"));
  options.out = folder.path("out");
  options.tool_script = folder.write("drag.toml",
                                     "interpolation = \"linear\"\n"
                                     "[[keyframe]]\ntime = 0.05\nadvance = 0\n"
                                     "[[keyframe]]\ntime = 0.1\nadvance = 0.003\n"
                                     "[[keyframe]]\ntime = 0.4\nadvance = 0.003\nslide = [0.03, 0]\n");
  options.record = folder.path("drag.rec");
  Log log;
  const auto run = [&] {
    Session session(options, app::readScene(options), log);
    runThrough(session);
    CHECK(session.failure().empty());
    const Snapshot& last = session.latest();
    REQUIRE(last.place);
    CHECK(static_cast<int>(last.u.size()) == modelOf(last, session.model()).nodeCount());
    CHECK(&modelOf(last, session.model()) != &session.model());
    return session.report();
  };
  const RunReport first = run();
  REQUIRE(first.follow);
  CHECK(first.follow->swaps >= 2);
  CHECK(first.follow->late_ticks == 0);
  CHECK(readAll(options.out + "/force.csv").find(",nodes,place_late\n") != std::string::npos);
  options.tool_script.clear();
  options.replay = std::exchange(options.record, "");
  const RunReport again = run();
  CHECK(again.state_hash == first.state_hash);
  CHECK(again.follow->swaps == first.follow->swaps);
}

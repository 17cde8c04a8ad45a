#include "mtled/import/import_command.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/solids.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/damaged_surfaces.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_file.h"
#include "io/surface_file.h"
#include "io/text_file.h"
#include "mtled/import/import_scene.h"
#include "mtled/import/import_unit.h"
#include "mtled/run/case_folder.h"
#include "support/captured_output.h"
#include "support/interrupted_child.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::tools;
using Catch::Contains;

namespace {

/// What the command says.
std::string import(const std::string& file, const std::string& out, const std::string& unit = "mm") {
  const CapturedOutput output;
  ImportOptions options;
  options.file = file;
  options.out = out;
  options.unit = unit;
  options.use_cache = false;
  const int code = importCommand(options);
  CHECK(code == 0);
  return output.said();
}

}  // namespace

TEST_CASE("A damaged surface is imported as a scene that opens, with a report", "[import][whole]") {
  const TempFolder folder;
  TriangleSurface surface = boxSurface({8, 6, 5}, 1.5);
  surface.triangles.erase(surface.triangles.begin() + 3);
  std::swap(surface.triangles[10][0], surface.triangles[10][1]);
  test::append(surface, boxSurface({2, 0.01, 2}, 0.5), {0, 0, 4.5});  // a fin too thin for any grid
  surface.vertices.emplace_back(0, 0, 400);
  surface.triangles.push_back({0, 1, static_cast<int>(surface.vertices.size()) - 1});
  for (Vec3& x : surface.vertices) x += Vec3(1e4, 0, 0);
  const std::string file = folder.path("my \"organ\".obj"), out = folder.path("out");
  writeObj(surface, file);
  const std::string said = import(file, out);
  CHECK_THAT(said, Contains("1 hole (3 open edges): closed"));
  CHECK_THAT(said, Contains("1 face facing inward or against the neighbours: turned"));
  CHECK_THAT(said, Contains("moved to the origin"));
  CHECK_THAT(said, Contains("1 stray vertex"));
  CHECK_THAT(said, Contains("1 part joined to the body, but too thin"));
  const auto report = nlohmann::json::parse(readWholeFile(out + "/report.json"));
  CHECK(report["holes_closed"] == 1);
  CHECK(report["distance_to_file_m"]["p95"].get<double>() < 1e-9);  // undamaged faces stay where they were
  REQUIRE(report["warnings"].size() == 1);
  CHECK_THAT(report["warnings"][0].get<std::string>(), Contains("what is there is lost") && Contains("1.5 mm off"));
  CHECK(report["kept_as_it_is"] == false);
  const Scene scene = readScene(out + "/scene.toml");
  CHECK(scene.name == "my _organ_");
  const SurfaceTree organ(organSurface(scene));
  CHECK(signedVolume(organ.surface()) == Approx(240e-9));
  CHECK(boundingBox(organ.surface()).center().norm() < 0.8e-3);  // half of the 1.5 mm that are lost on one side
  CHECK(organ.signedDistance(scene.tools[0].position + scene.tools[0].shape.radius * Vec3::UnitZ()) >
        scene.tools[0].shape.radius);
  const double node_steps = report["nodes"].get<double>() * report["steps_per_tick"].get<double>();
  CHECK(node_steps > 0.3 * node_steps_budget);
  CHECK(node_steps < 1.2 * node_steps_budget);

  // The same at load.
  Scene repaired = scene;
  repaired.organs[0].surface_file = file;
  repaired.organs[0].surface_scale = 0.001;
  CHECK_THAT(refusal([&] { organSurface(repaired); }), Contains("`mtled import " + file + "`"));
  repaired.organs[0].repair_surface = true;
  CHECK(signedVolume(organSurface(repaired)) == Approx(240e-9));

  CHECK_THAT(refusal([&] { import(out + "/surface.obj", out, "m"); }), Contains("written over"));

  // What is refused or interrupted leaves the folder as it was.
  const std::string scene_before = readWholeFile(out + "/scene.toml");
  writeObj(boxSurface({100, 80, 0.4}, 5), folder.path("plate.obj"));
  CHECK_THAT(refusal([&] { import(folder.path("plate.obj"), out); }), Contains("so thin for its size"));
  CHECK(test::codeWhenInterrupted(out + "/import.part/scene.toml", [&] {
          import(file, out);
          return 0;
        }) == 99);
  CHECK(readWholeFile(out + "/scene.toml") == scene_before);
  CHECK(!std::filesystem::exists(out + "/import.part"));
}

TEST_CASE("A folder gets its files all at once, the scene last, or stays as it was", "[import]") {
  const TempFolder folder;
  const std::string out = folder.path("a/b/c");
  const std::vector<std::string> names = {"surface.obj", "scene.toml"};
  {
    const CaseFolder refused(out, names, {});
    writeWholeFile(refused.aside("scene.toml"), "1");
    CHECK(!std::filesystem::exists(refused.file("scene.toml")));
    CHECK(refused.inPlace("at " + refused.aside("scene.toml") + ":3") == "at " + refused.file("scene.toml") + ":3");
  }
  CHECK(!std::filesystem::exists(folder.path("a")));
  {
    CaseFolder whole(out, names, {});
    for (const std::string& name : names) writeWholeFile(whole.aside(name), name);
    whole.takePlace();
  }
  CHECK(readWholeFile(out + "/scene.toml") == "scene.toml");
  CHECK(readWholeFile(out + "/surface.obj") == "surface.obj");
  CHECK(!std::filesystem::exists(out + "/import.part"));
  CHECK_THAT(refusal([&] { CaseFolder(out, names, {out + "/surface.obj"}); }), Contains("written over"));
  // Told before the file is read, which is not there.
  const std::string no_folder = folder.write("file", "") + "/out";
  CHECK_THROWS_WITH(import(folder.path("none.stl"), no_folder), Contains("can't write " + no_folder));
}

TEST_CASE("Nodes are counted before there are any, within a quarter", "[import][whole]") {
  const std::pair<TriangleSurface, double> bodies[] = {{boxSurface({0.1, 0.08, 0.05}, 0.01), 0.008},
                                                       {boxSurface({0.1, 0.08, 0.005}, 0.01), 0.0045},
                                                       {boxSurface({0.1, 0.08, 0.002}, 0.01), 0.0019},
                                                       {ellipsoidSurface({0.05, 0.04, 0.03}, 0.005), 0.006}};
  for (const auto& [surface, spacing] : bodies) {
    const SurfaceTree tree(surface);
    SpacingField field;
    field.spacing = spacing;
    const BodyMeasures body = measuresOf(tree);
    CHECK(nodesAt(body, spacing) == Approx(static_cast<double>(makeNodeCloud(tree, field, 1).X.size())).epsilon(0.25));
    const double first = firstSpacing(body);
    CHECK(nodesAt(body, first) * stepsAt(body, first) <= node_steps_budget);
    CHECK(nodesAt(body, first) * stepsAt(body, first) > 0.5 * node_steps_budget);
  }
}

TEST_CASE("The unit of a surface is guessed only where its size leaves no doubt", "[import]") {
  CHECK(surfaceUnit("a.stl", "", 217).name == "mm");
  CHECK(surfaceUnit("a.stl", "", 0.217).name == "m");
  CHECK_THAT(surfaceUnit("a.stl", "", 217).reason, Contains("21.7 cm long") && Contains("--unit"));
  CHECK(surfaceUnit("a.stl", "cm", 217).length == 0.01);
  for (const double length : {2.0, 25.0, 1e5, 1e-4}) {
    INFO(length);
    CHECK_THAT(refusal([&] { surfaceUnit("a.stl", "", length); }),
               Contains("a.stl: ") && Contains("does not say in which unit") && Contains("with --unit cm"));
  }
  CHECK_THAT(refusal([] { surfaceUnit("a.stl", "", 25); }), Contains("25 mm with --unit mm, 25 cm with --unit cm"));
  // Even where it is said: such a scene would open, and stand still.
  CHECK_THAT(refusal([] { surfaceUnit("a.stl", "mm", 0.06); }),
             Contains("0.06 mm long") && Contains("60 mm with --unit m"));
  CHECK_THAT(refusal([] { surfaceUnit("a.stl", "mm", 1e-40); }), Contains("damaged") && !Contains("--unit"));
  CHECK_THAT(refusal([] { surfaceUnit("a.stl", "m", 60); }), Contains("60 m long"));
}

TEST_CASE("Each part of an imported organ is held, and the tool starts above it, free", "[import]") {
  TriangleSurface two = boxSurface({0.02, 0.02, 0.02}, 0.005);
  const TriangleSurface high = boxSurface({0.01, 0.01, 0.03}, 0.005);
  const int first = static_cast<int>(two.vertices.size());
  for (const Vec3& x : high.vertices) two.vertices.emplace_back(x + Vec3(0.018, 0, 0.01));
  for (const auto& [a, b, c] : high.triangles) two.triangles.push_back({a + first, b + first, c + first});
  const SurfaceTree organ(two);
  const ImportedScene scene = chooseScene(organ, 0.002);
  REQUIRE(scene.held.size() == 2);
  for (int part = 0; part < 2; ++part) {
    const double base = part == 0 ? 0 : 0.01;
    CHECK(scene.held[part].min.z() < base);
    CHECK(scene.held[part].max.z() > base + 0.0014);
    CHECK(scene.held[part].max.z() < base + 0.006);
  }
  CHECK(organ.signedDistance(scene.tool_tip + scene.tool_radius * Vec3::UnitZ()) > scene.tool_radius);
  CHECK(scene.tool_tip.z() > 0.02);
}

TEST_CASE("Scans are told from surfaces, and what is no surface is refused", "[import][refusal]") {
  const TempFolder folder;
  CHECK_THAT(refusal([&] { import(folder.path("brain.nii.gz"), folder.path("out")); }), Contains("brain.nii.gz"));
  CHECK_THAT(refusal([&] { import(folder.path("none.stl"), folder.path("out")); }), Contains("does not exist"));
  CHECK_THAT(refusal([&] { import(folder.write("a.xyz", "0 0 0\n"), folder.path("out")); }), Contains(".ply"));
  // Half of a cube, and why: the other faces name a vertex that is not there.
  const std::string half =
      "v 0 0 0\nv 60 0 0\nv 60 60 0\nv 0 60 0\nv 0 0 60\nv 60 0 60\nf 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\n"
      "f 2 3 99\nf 2 99 6\nf 5 6 99\n";
  CHECK_THAT(refusal([&] { import(folder.write("half.obj", half), folder.path("out")); }),
             Contains("does not enclose a volume") && Contains("3 of the file's faces can't be read"));
  CHECK(!std::filesystem::exists(folder.path("out")));
}

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "support/bad_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

// What a scene says for solutions without a window: quadrature, boundaries that move, [solve].

namespace {

/// A folder with the probes file that the scene names.
struct SceneFolder : TempFolder {
  SceneFolder() {
    std::filesystem::create_directory(path("points"));
    write("points/probes.csv", "X,Y,Z\n0,0,0\n");
  }
  Scene scene(const std::string& text) const { return readScene(write("s.toml", text)); }
};

}  // namespace

TEST_CASE("Quadrature, motions and [solve] of a scene arrive where they belong", "[io][scene]") {
  const SceneFolder folder;
  const Scene s = folder.scene(solved_scene);
  CHECK(s.discretization.quadrature.points_per_cell == 5);
  CHECK(s.discretization.quadrature.accuracy == 0.01);
  CHECK(s.discretization.quadrature.division == 2);
  CHECK(s.discretization.quadrature.max_depth == 6);
  CHECK(s.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Ebciem);
  CHECK(s.materials[1].region.kind == Region::Kind::Shell);
  CHECK(s.materials[1].region.distance == 0.002);

  REQUIRE(s.boundaries.size() == 5);
  CHECK(s.boundaries[0].name == "base");
  CHECK(s.boundaries[1].name == "fixed 2");
  CHECK(s.boundaries[2].name == "prescribed 1");
  CHECK(s.boundaries[3].name == "ear");
  CHECK(s.boundaries[4].name == "prescribed 3");
  CHECK(s.boundaries[1].region.kind == Region::Kind::Shell);
  CHECK(s.boundaries[1].region.distance == 0);
  CHECK(s.boundaries[1].angle == 0);
  CHECK(s.boundaries[1].duration == 0);

  const BoundarySpec& disc = s.boundaries[2];
  CHECK(disc.region.kind == Region::Kind::Cylinder);
  CHECK(disc.region.point == Vec3(0, 0, 0.016));
  CHECK(disc.region.normal == Vec3::UnitZ());
  CHECK(disc.region.radius == 0.005);
  CHECK(disc.region.height == 0.002);
  CHECK(disc.translation == Vec3(0, 0, -0.002));
  CHECK(disc.axis_point == Vec3(0.001, 0, 0));
  CHECK(disc.axis == Vec3(0, 0, -1));
  CHECK(disc.angle == Approx(std::numbers::pi / 2).epsilon(1e-15));
  CHECK(disc.duration == 0.5);
  CHECK(disc.curve.kind == LoadCurve::Kind::Linear);
  CHECK(disc.curve.at(0.2, disc.duration) == Approx(0.4).epsilon(1e-15));

  const BoundarySpec& ear = s.boundaries[3];
  CHECK(ear.translation == Vec3::Zero());
  CHECK(ear.axis == Vec3::UnitX());
  CHECK(ear.angle == Approx(-std::numbers::pi / 6).epsilon(1e-15));
  CHECK_FALSE(ear.component[0]);
  CHECK(ear.component[1]);
  CHECK(ear.curve.kind == LoadCurve::Kind::Table);
  CHECK(ear.curve.time == std::vector<double>{0, 0.1, 0.4});
  CHECK(ear.curve.fraction == std::vector<double>{0, 1, -0.5});
  CHECK(ear.duration == 0.4);
  CHECK(ear.curve.at(0.2, ear.duration) == Approx(0.5).epsilon(1e-14));
  CHECK(ear.curve.at(9, ear.duration) == -0.5);

  CHECK(s.boundaries[4].angle == 0);
  CHECK(s.boundaries[4].curve.kind == LoadCurve::Kind::Smooth);

  CHECK(s.solve.mode == SolveSpec::Mode::Transient);
  CHECK(s.solve.end_time == 0.75);
  CHECK(s.solve.frames == 25);
  CHECK(s.solve.probes_file == folder.path("points/probes.csv"));
  CHECK(s.solve.place.line == 59);

  const Scene still = folder.scene(
      replaced(solved_scene, "mode = \"transient\"", "mode = \"static\"\ntolerance = 1e-3\nload_steps = 40"));
  CHECK(still.solve.mode == SolveSpec::Mode::Static);
  CHECK(still.solve.tolerance == 1e-3);
  CHECK(still.solve.load_steps == 40);
  // A longer duration than the table's is taken: the last share is held.
  CHECK(folder.scene(replaced(solved_scene, "angle = -30", "angle = -30\nduration = 0.6")).boundaries[3].duration ==
        0.6);
}

TEST_CASE("Bad quadrature, motions and [solve] are refused at their place, with advice", "[io][scene][refusal]") {
  const SceneFolder folder;
  const std::vector<BadText> bad = {
      // [discretization]
      {"quadrature_accuracy = 0.01", "quadrature_accuracy = 1.5", ":8:23", "out of range", "0 .. 1"},
      {"quadrature_accuracy = 0.01\n", "", ":8:1",
       "\"quadrature_division\" means nothing without \"quadrature_accuracy\"", "remove it"},
      {"quadrature_accuracy = 0.01\nquadrature_division = 2\n", "", ":8:1", "\"quadrature_depth\" means nothing",
       "remove it"},
      {"quadrature_division = 2", "quadrature_division = 3", ":9:23", "\"quadrature_division\" = 3 is no choice",
       "2, 4 or 8"},
      {"quadrature_depth = 6", "quadrature_depth = 9", ":10:20", "out of range", "0 .. 8"},
      {"\"ebciem\"", "\"lagrange\"", ":11:19", "\"boundary_method\" is \"lagrange\"", "sebciem or ebciem"},
      // regions
      {"height = 0.002\n", "", ":30:1", "the key \"height\" is missing", "a cylinder needs it"},
      {"normal = [0, 0, 2]\n", "", ":30:1", "the key \"normal\" is missing", "a cylinder needs it"},
      {"height = 0.002", "height = 0", ":35:10", "\"height\" = 0 m is out of range", "> 0"},
      {"height = 0.002", "height = 0.002\ndistance = 1", ":36:1", "\"distance\" means nothing to a cylinder",
       "remove it"},
      {"distance = 0\n", "", ":27:1", "the key \"distance\" is missing", "a shell needs it"},
      {"distance = 0\n", "distance = 0\nnormal = [0, 0, 1]\n", ":30:1", "\"normal\" means nothing to a shell",
       "remove it"},
      {"radius = 0.001\naxis", "radius = 0.001\nheight = 1\naxis", ":47:1", "\"height\" means nothing to a sphere",
       "remove it"},
      // names
      {"name = \"ear\"", "name = \"base\"", ":43:1", "the name \"base\" is taken by line 21", "a name of its own"},
      {"name = \"ear\"", "name = \"prescribed 1\"", ":43:1", "the name \"prescribed 1\" is taken by line 30",
       "a name of its own"},
      {"name = \"base\"", "name = \"fixed 2\"", ":27:1", "the name \"fixed 2\" is taken by line 21",
       "a name of its own"},
      {"name = \"ear\"", "name = \"left, ear\"", ":43:1", "\"name\" is \"left, ear\"", "without commas"},
      {"name = \"ear\"", "name = \" \"", ":43:1", "\"name\" is \" \"", "give a name"},
      {"name = \"ear\"", "name = \"a\\nb\"", ":43:1", "\"name\" is \"a?b\"", "line ends"},
      // motions
      {"translation = [0, 0.001, 0]\n", "", ":53:1", "neither a translation nor a rotation",
       "give translation = [x, y, z]"},
      {"axis = [1, 0, 0]\n", "", ":42:1", "the key \"axis\" is missing", "a rotation needs it"},
      {"axis_point = [0, 0, 0]\n", "", ":42:1", "the key \"axis_point\" is missing", "a rotation needs it"},
      {"angle = -30\n", "", ":42:1", "the key \"angle\" is missing", "a rotation needs it"},
      {"axis = [1, 0, 0]", "axis = [0, 0, 0]", ":48:1", "\"axis\" is zero", "[0, 0, 1]"},
      {"angle = -30", "angle = -5000", ":49:9", "\"angle\" = -5000 degrees is out of range", "-3600 .. 3600"},
      {"duration = 2\n", "", ":53:1", "the key \"duration\" is missing", "a motion without \"curve_table\" needs it"},
      {"duration = 2", "duration = 0", ":58:12", "\"duration\" = 0 s is out of range", "> 0"},
      {"\"linear\"", "\"cubic\"", ":41:9", "\"curve\" is \"cubic\"", "smooth or linear"},
      {"angle = -30", "angle = -30\ncurve = \"linear\"", ":50:1", "both \"curve\" and \"curve_table\"", "one of them"},
      {"angle = -30", "angle = -30\nduration = 0.3", ":50:1", "\"curve_table\" goes on after \"duration\"", "leave"},
      {"[[0, 0], [0.1, 1.0],\n               [0.4, -0.5]]", "3", ":51:15", "\"curve_table\" is a whole number",
       "list of pairs"},
      {"[[0, 0], [0.1, 1.0],\n               [0.4, -0.5]]", "[]", ":51:15", "\"curve_table\" has 0 rows",
       "[[0.0, 0.0]"},
      {"[[0, 0], [0.1, 1.0],\n               [0.4, -0.5]]", "[[0, 0]]", ":51:15", "\"curve_table\" has 1 rows",
       "[[0.0, 0.0]"},
      {"[0.4, -0.5]", "[0.1, -0.5]", ":52:16", "the time of \"curve_table[2]\" is not later", "order"},
      {"[0.4, -0.5]", "[0.4, -0.5, 1]", ":52:16", "\"curve_table[2]\" is not a pair", "rows of time and value"},
      {"[0.4, -0.5]", "0.4", ":52:16", "\"curve_table[2]\" is not a pair", "rows of time and value"},
      {"[0.4, -0.5]", "[0.4, inf]", ":52:22", "curve_table[2][1] is not finite", "finite"},
      {"[0.4, -0.5]", "[\"a\", -0.5]", ":52:17", "\"curve_table\" is text", "list of pairs"},
      {"[[0, 0],", "[[0.05, 0],", ":51:16", "does not start at [0.0, 0.0]", "rows"},
      {"[[0, 0],", "[[0, 0.5],", ":51:16", "does not start at [0.0, 0.0]", "rows"},
      // [solve]
      {"\"transient\"", "\"dynamic\"", ":60:8", "\"mode\" is \"dynamic\"", "static or transient"},
      {"end_time = 0.75", "end_time = 0.75\ntolerance = 1e-3", ":62:1",
       "\"tolerance\" means nothing to a transient solution", "remove it"},
      {"end_time = 0.75", "end_time = 0.75\nload_steps = 3", ":62:1",
       "\"load_steps\" means nothing to a transient solution", "remove it"},
      {"mode = \"transient\"", "tolerance = 0", ":60:13", "out of range", "> 0 .. 0.1"},
      {"mode = \"transient\"", "load_steps = 0", ":60:14", "out of range", "1 .. 10000"},
      {"end_time = 0.75", "end_time = -1", ":61:12", "out of range", ">= 0"},
      {"frames = 25", "frames = 0", ":62:10", "out of range", "1 .. 10000"},
      {"points/probes.csv", "points/none.csv", ":63:1", "there is no probes file", "scene file's folder"},
      {"frames = 25", "frame = 25", ":62:1", "unknown key \"frame\" in [solve]", "did you mean \"frames\"?"},
  };
  checkRefused(folder, "s.toml", solved_scene, bad, [](const std::string& path) { readScene(path); });
}

#include <catch2/catch.hpp>
#include <cmath>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "io/scene_texts.h"
#include "support/bad_texts.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("Bad scenes are refused at their place, with advice", "[io][scene][refusal]") {
  TempFolder folder;
  const std::vector<BadText> bad = {
      // not TOML
      {"rate = 1000", "rate = ", ":44:8", "not valid TOML", "key = value"},
      {"rate = 1000", "rate = 1000\nrate = 500", ":45:", "not valid TOML", "rate"},
      {"[force]", "[force", ":58:", "not valid TOML", "[name]"},
      // keys
      {"time_step", "time_stp", ":45:1", "unknown key \"time_stp\" in [dynamics]", "did you mean \"time_step\"?"},
      {"young = 1000", "E = 1000", ":21:1", "unknown key \"E\" in [[material]]", "did you mean \"young\"?"},
      {"colour", "color", ":6:1", "unknown key \"color\" in [organ]", "did you mean \"colour\"?"},
      {"damping = 10", "young = 10", ":47:1", "unknown key \"young\" in [dynamics]", "belongs to material"},
      {"damping = 10", "wobbliness = 10", ":47:1", "unknown key \"wobbliness\"",
       "known here: rate, catch_up, time_step"},
      {"[camera]", "[kamera]", ":61:2", "unknown key \"kamera\" in the file's top level", "\"camera\""},
      {"centre = [0, 0, 0.01], radius", "centre = [0, 0, 0.01], raduis", ":29:", "unknown key \"raduis\"",
       "\"radius\""},
      // missing
      {"spacing = 0.004\n", "follow = false\n", ":7:1", "the key \"spacing\" is missing in [discretization]",
       "spacing = number in m"},
      {"spacing = 0.004\n", "follow = true\nspacing = 0\n", ":9:11", "\"spacing\" = 0 m is out of range", "> 0"},
      {"spacing = 0.004\n", "follow = 1\n", ":8:10", "\"follow\" is a whole number", "true or false"},
      {"height = 0.017\n", "", ":2:1", "the key \"height\" is missing", "a cylinder needs it"},
      {"distance = 1e-5\n", "", ":30:1", "the key \"distance\" is missing", "near-plane"},
      {"D1 = 1.2598e-4\n", "", ":23:1", "the key \"D1\" is missing", "an Ogden material needs it"},
      {"shape = \"near-plane\"\n", "", ":30:1", "the key \"shape\" is missing in [[fixed]]", "shape = text"},
      {"position = [0, 0, 0.03]\n", "", ":49:1", "the key \"position\" is missing in [tool]", "3 numbers in m"},
      // types
      {"rate = 1000", "rate = \"1000\"", ":44:8", "\"rate\" is text", "give number in Hz"},
      {"threads = 2", "threads = 2.5", ":48:11", "\"threads\" is a number", "give whole number"},
      {"surface_only = true", "surface_only = 1", ":40:16", "\"surface_only\" is a whole number", "true or false"},
      {"target = [0, 0, 0.01]", "target = [0, 0.01]", ":62:10", "has 2 entries", "give 3 numbers"},
      {"target = [0, 0, 0.01]", "target = [0, 0, \"a\"]", ":62:17", "\"target\" is text", "3 numbers in m"},
      {"name = \"Everything\"", "name = 3", ":1:8", "\"name\" is a whole number", "give text"},
      {"[[prescribed]]", "[prescribed]", ":35:1", "\"prescribed\" is a table", "[[prescribed]]"},
      {"components = [\"z\"]", "components = [\"w\"]", ":39:15", "no axis", "[\"z\"]"},
      // ranges and choices
      {"poisson = 0.45", "poisson = 0.5", ":22:11", "\"poisson\" = 0.5 is out of range", "0 .. 0.4999"},
      {"young = 1000", "young = -1", ":21:9", "\"young\" = -1 Pa is out of range", "> 0"},
      {"young = 1000", "young = 1e-30", ":21", "e-31 Pa is that of no matter", "in Pa"},
      {"young = 1000", "young = nan", ":21:9", "\"young\" is not finite", "finite"},
      {"rate = 1000", "rate = 50", ":44:8", "\"rate\" = 50 Hz is out of range", "100 .. 2000 Hz"},
      {"support_factor = 2", "support_factor = 9", ":12:18", "out of range", "1.4 .. 4"},
      {"seed = 9", "seed = -9", ":9:8", "out of range", "0 .. 4294967295"},
      {"points_per_cell = 1", "cells_per_point = 2.5", ":10:19", "\"cells_per_point\" = 2.5 is out of range", "1 .. 2"},
      {"points_per_cell = 1", "points_per_cell = 3", ":10:19", "\"points_per_cell\" = 3 is no choice", "1, 4 or 5"},
      {"colour = [0.1, 0.2, 0.3]", "colour = [10, 0.2, 0.3]", ":6:11", "colour[0] = 10 is out of range", "0 .. 1"},
      {"\"linear\"", "\"cubic\"", ":11:9", "\"basis\" is \"cubic\"", "linear or quadratic"},
      {"shape = \"near-plane\"", "shape = \"plane\"", ":31:9", "\"shape\" is \"plane\"",
       "half-space, box, sphere, near-plane, cylinder or shell"},
      // contradictions
      {"points_per_cell = 1", "points_per_cell = 4\ncells_per_point = 1.5", ":11:1",
       "\"cells_per_point\" means nothing with more than one point per cell", "remove it"},
      {"points_per_cell = 1", "quadrature_accuracy = 0.1\ncells_per_point = 1.5", ":11:1",
       "\"cells_per_point\" means nothing with \"quadrature_accuracy\"", "remove it"},
      {"height = 0.017", "height = 0.017\nsize = [1, 1, 1]", ":6:1", "\"size\" means nothing to a cylinder",
       "remove it"},
      {"solid = \"cylinder\"", "solid = \"cylinder\"\nsurface = \"a.obj\"", ":3:1", "both \"surface\" and \"solid\"",
       "give"},
      {"solid = \"cylinder\"\nradius = 0.015\nheight = 0.017", "", ":2:1", "neither \"surface\" nor \"solid\"", "give"},
      {"solid = \"cylinder\"\nradius = 0.015\nheight = 0.017", "surface = \"a.obj\"\nunit = \"mm\"", ":3:1",
       "there is no surface file", "scene file's folder"},
      {"normal = [0, 0, 2]", "normal = [0, 0, 0]", ":33:1", "\"normal\" is zero", "[0, 0, 1]"},
      // Each number is finite, the length is not: divided by it, all would be zero.
      {"normal = [0, 0, 2]", "normal = [1.7e308, 1.7e308, 0]", ":33:10", "the length of \"normal\"", "smaller"},
      {"direction = [0, 3, -4]", "direction = [1.7e308, 0, 1.7e308]", ":55:13", "the length of \"direction\"",
       "smaller"},
      {"translation = [0, 0, -0.002]", "translation = [1.7e308, 1.7e308, 0]", ":41:15", "\"translation\"", "smaller"},
      {"name = \"Everything\"", "name = \"one\\ntwo\"", ":1:1", "\"name\" is \"one?two\"", "line ends"},
      {"name = \"Everything\"", "name = \"\\u009b2J\"", ":1:1", "\"name\" is", "control characters"},
      {"name = \"Everything\"", "name = \"one \"", ":1:1", "\"name\" is \"one \"", "blanks at its ends"},
      {"[[prescribed]]", "[[prescribed]]\nname = \" base\"", ":36:1", "\"name\" is \" base\"", "blanks at its ends"},
      {"spacing = 0.001", "spacing = 0.004", ":17:1", "not below the global one", "less than"},
      {"max = [0.01, 0.01, 0.018]", "max = [0.01, 0.01, 0.0]", ":37:1", "\"min\" is above its \"max\"", "swap"},
      {"time_step = 0.0005", "time_step = 0.0003", ":45:1", "not a whole number of steps", "0.00025 s (4 steps"},
      {"time_step = 0.0005", "time_step = 0.005", ":45:1", "not a whole number of steps", "0.001 s (1 steps"},
      {"alpha = [-1.1, 2]", "alpha = [-1.1]", ":25:1", "\"mu\" has 2 terms and \"alpha\" 1", "same number"},
      {"alpha = [-1.1, 2]", "alpha = [-1.1, 0]", ":26:1", "an exponent is 0", "leave the term out"},
      {"mu = [600, 43.6]", "mu = [600, -700]", ":25:1", "is not positive", "signs"},
      {"poisson = 0.45", "poisson = 0.45\nD1 = 1", ":23:1", "\"D1\" means nothing to a neo-Hookean", "remove"},
      {"region = { shape = \"sphere\", centre = [0, 0, 0.01], radius = 0.005 }\n", "", ":23:1", "no region",
       "add region"},
      {"edge_radius = 0.0005", "edge_radius = 0.006", ":53:1", "exceeds the tool's radius", "capsule"},
      {"shape = \"cylinder\"", "shape = \"capsule\"", ":53:1", "\"edge_radius\" means nothing to a capsule", "remove"},
      {"length = 0.03", "length = 0.0009", ":52:1", "shorter than its two rounded rims", "lengthen"},
      {"shape = \"cylinder\"\nradius = 0.005\nlength = 0.03\nedge_radius = 0.0005",
       "shape = \"capsule\"\nradius = 0.005\nlength = 0.003", ":52:1", "shorter than two radii", "sphere"},
  };
  checkRefused(folder, "full.toml", full_scene, bad, [](const std::string& path) { readScene(path); });
}

TEST_CASE("A missing table or file is named", "[io][scene][refusal]") {
  TempFolder folder;
  const auto message = [&](const std::string& text) {
    return refusal([&] { readScene(folder.write("s.toml", text)); });
  };
  CHECK_THAT(message(""), Contains("s.toml") && Contains("the key \"organ\" is missing") && Contains("add an [organ]"));
  CHECK_THAT(message(minimal_scene.substr(0, minimal_scene.find("[[fixed]]"))),
             Contains("\"fixed\" is missing") && Contains("[[fixed]]"));
  // A prescribed region may hold it.
  CHECK_NOTHROW(readScene(folder.write("p.toml", minimal_scene.substr(0, minimal_scene.find("[[fixed]]")) +
                                                     "[[prescribed]]\nshape = \"sphere\"\ncentre = [0, 0, 0]\nradius = "
                                                     "0.1\ntranslation = [0, 0, 0.001]\nduration = 1\n")));
  CHECK_THAT(message(replaced(minimal_scene, "[[material]]", "[material]")),
             Contains("s.toml:6:1: \"material\" is a table; write each entry as [[material]]"));
  CHECK_THAT(message(minimal_scene + "[[material]]\nmodel = \"neo-hookean\"\nyoung = 1\npoisson = 0.3\nregion = 3\n"),
             Contains(":18:10") && Contains("write it as a table"));
  CHECK_THAT(refusal([&] { readScene(folder.path("none.toml")); }), Contains("none.toml: the file does not exist"));
  CHECK_THAT(refusal([&] { readScene(folder.path("")); }), Contains("folder"));
}

TEST_CASE("A direction is a unit vector, however short or long it is given", "[io][scene]") {
  TempFolder folder;
  const auto normal = [&](const std::string& text) {
    const std::string path = folder.write("s.toml", replaced(minimal_scene, "normal = [0, 0, 1]", "normal = " + text));
    return readScene(path).boundaries.at(0).region.normal;
  };
  CHECK((normal("[5e-324, 5e-324, 0]") - Vec3(1, 1, 0) / std::sqrt(2.0)).norm() < 1e-15);
  CHECK((normal("[3e-310, 0, -4e-310]") - Vec3(0.6, 0, -0.8)).norm() < 1e-13);  // 46 bits are left of such numbers
  CHECK((normal("[1e308, 0, 1e308]") - Vec3(1, 0, 1) / std::sqrt(2.0)).norm() < 1e-15);
}

TEST_CASE("A scene's name from its file's can be printed, whatever bytes it has", "[io][scene]") {
  TempFolder folder;
  CHECK(readScene(folder.write("one\ntwo \xff.toml", minimal_scene)).name == "one?two ?");
  CHECK(readScene(folder.write("Leber \xc3\xa4.toml", minimal_scene)).name == "Leber \xc3\xa4");
}

TEST_CASE("A surface or a scan in place of a scene is told what makes one of it", "[io][scene][refusal]") {
  const TempFolder folder;
  for (const char* name : {"organ.STL", "organ.obj", "head.nii.gz"})
    CHECK_THAT(refusal([&] { readScene(folder.write(name, "v 0 0 0")); }),
               Contains("no scene") && Contains("mtled import") && Contains(name));
}

TEST_CASE("A cloud can follow a tool that is there", "[io][scene][refusal]") {
  const TempFolder folder;
  const std::string follows = replaced(minimal_scene, "spacing = 0.01", "follow = true"),
                    tool = "[tool]\nshape = \"sphere\"\nradius = 0.01\nposition = [0, 0, 0.07]\n",
                    lump = "[[lump]]\ncentre = [0, 0, 0.03]\nradius = 0.008\nyoung = 40000\n",
                    relaxes = replaced(follows, "poisson = 0.49", "poisson = 0.49\nrelaxation = [[0.3, 0.1]]");
  const auto read = [&](const std::string& text) { return readScene(folder.write("f.toml", text)); };
  CHECK_THAT(refusal([&] { read(follows); }), Contains("f.toml:5:") && Contains("no tool that the cloud could follow"));
  const Scene scene = read(follows + tool);
  CHECK(scene.discretization.follow);
  CHECK(scene.dynamics.gradient_precision == GradientPrecision::Int16);
  CHECK(scene.discretization.quadrature.cells_per_point > 1);
  const Scene said = read(replaced(follows, "follow = true", "follow = true\ncells_per_point = 1") +
                          "[dynamics]\ngradient_precision = \"float32\"\n" + tool);
  CHECK(said.dynamics.gradient_precision == GradientPrecision::Float32);
  CHECK(said.discretization.quadrature.cells_per_point == 1);
  CHECK(scene.dynamics.mass_scaling == 0.05);
  CHECK(read(follows + "[dynamics]\nmass_scaling = 0\n" + tool).dynamics.mass_scaling == 0);
  CHECK(read(follows + "[dynamics]\ntime_step = 0.0005\n" + tool).dynamics.mass_scaling == 0);
  CHECK(read(minimal_scene + tool).dynamics.mass_scaling == 0);
  CHECK(scene.tools[0].max_speed == 1);  // m/s, or so many radii a second
  CHECK(read(replaced(follows + tool, "radius = 0.01", "radius = 0.0005")).tools[0].max_speed == Approx(0.2));
  CHECK(read(replaced(follows + tool, "radius = 0.01", "radius = 0.0005\nmax_speed = 0.7")).tools[0].max_speed == 0.7);
  CHECK(scene.discretization.spacing == Approx(2.4 * 0.5 * 0.01));
  CHECK(!read(minimal_scene + tool).discretization.follow);
  // A spacing beside it is that near the tool; one that can't be is refused at its line.
  const auto spaced = [&](const char* spacing) {
    return replaced(follows, "follow = true", std::string("follow = true\nspacing = ") + spacing) + tool;
  };
  CHECK(read(follows + tool).discretization.at_tools == 0);
  CHECK(read(spaced("0.0025")).discretization.at_tools == 0.0025);
  CHECK(read(spaced("0.0025")).discretization.spacing == Approx(0.006));
  CHECK_THAT(refusal([&] { loadModel(read(spaced("0.0012"))); }),
             Contains("f.toml:6:1") && Contains("more than 100000 nodes") && Contains("or more"));
  CHECK_THAT(refusal([&] { loadModel(read(spaced("0.06"))); }),
             Contains("f.toml:6:1") && Contains("more than the body is thick") && Contains("give a spacing between"));
  CHECK(read(relaxes + tool).discretization.follow);
  // Where nothing is said it follows, or the scene has to say more, with a number that suits the tool.
  const auto silent = [](const std::string& text) { return replaced(text, "follow = true", ""); };
  CHECK(read(silent(follows) + tool).discretization.follow);
  CHECK(read(silent(follows) + tool + lump).discretization.follow);
  CHECK_THAT(refusal([&] { read(silent(follows)); }),
             Contains("f.toml:") && Contains("\"spacing\" is missing") && Contains("no tool"));
}

TEST_CASE("An organ of which nothing can move is refused", "[io][scene][refusal]") {
  const TempFolder folder;
  const std::string all =
      replaced(minimal_scene, "point = [0, 0, 0.001]\nnormal = [0, 0, 1]", "point = [0, 0, 0.1]\nnormal = [0, 0, 1]");
  CHECK_THAT(refusal([&] { loadModel(readScene(folder.write("f.toml", all))); }),
             Contains("f.toml:") && Contains("all nodes are fixed") && Contains("smaller"));
}

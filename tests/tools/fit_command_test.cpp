#include "mtled/fit_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "io/load_model.h"
#include "mtled/fit_search.h"
#include "mtled/rate_check.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// A body, a material and a tool drawn by lot: none that anything was tuned on.
Scene randomScene(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&random](double low, double high) { return low + (high - low) * std::uniform_real_distribution<>()(random); };
  Scene scene;
  scene.name = "random " + std::to_string(seed);
  double top = 0;
  if (seed % 2 == 0) {
    scene.solid = Scene::Solid::Box;
    scene.size = Vec3(between(0.05, 0.08), between(0.05, 0.08), between(0.025, 0.04));
    top = scene.size.z();
  } else {
    scene.solid = Scene::Solid::Ellipsoid;
    scene.upper_half = true;
    scene.semi_axes = Vec3(between(0.03, 0.05), between(0.03, 0.05), between(0.03, 0.04));
    top = scene.semi_axes.z();
  }
  scene.materials.emplace_back();
  scene.materials[0].young = between(1000, 8000);
  scene.materials[0].poisson = between(0.4, 0.49);
  BoundarySpec base;
  base.region.kind = Region::Kind::HalfSpace;
  base.region.point = Vec3(0, 0, 1e-6);
  scene.boundaries.push_back(base);
  scene.tool.radius = between(0.008, 0.012);
  scene.tool_position = Vec3(between(-0.01, 0.01), between(-0.01, 0.01), top + 0.002);
  scene.spacing = between(0.0075, 0.009);
  scene.damping = 60;
  return scene;
}

}  // namespace

// A minute of work: a ctest of its own, not under sanitizers (tests/CMakeLists.txt).
TEST_CASE("The force error that fit expects is within a factor of two of the measured one, on scenes drawn by lot", "[.][random_scenes]") {
  const auto quiet = [](double, const std::string&) {};
  for (const unsigned seed : {11U, 12U, 13U}) {
    const Scene scene = randomScene(seed);
    const Model model = loadModel(scene);
    const ToolWay way = indentationWay(model);
    const auto probes = surfaceProbes(model, 50);
    const WorkedOn place = workedOn(model, way);
    const ScriptedRun run = runWay(model, way, probes, 2);
    REQUIRE(run.sound());
    // As fit does ...
    const Fineness fineness = fitFineness(1);
    const ConvergedRun converged = convergedRun(model, way, probes, place, fineness, 2, quiet);
    const double expected = expectedError(errorOf(run, converged.run), converged, fineness.coarser);
    // ... and against a solution finer than what fit compares with.
    const ConvergedRun finer = convergedRun(model, way, probes, place, {0.8, 0.38, 1.35}, 2, quiet);
    const double measured = errorOf(run, finer.run).force;
    CAPTURE(seed, model.nodeCount(), converged.about.nodes, finer.about.nodes, expected, measured, converged.about.convergence.force);
    CHECK(measured > 0);
    CHECK(expected < 2 * measured);
    CHECK(expected > measured / 2);
  }
}

TEST_CASE("fit refuses what it can not fit, with what to do", "[fit]") {
  const TempFolder folder;
  const std::string scene = folder.write("block.toml",
                                       "name = \"block\"\n[organ]\nsolid = \"box\"\nsize = [0.06, 0.06, 0.03]  # m\n[discretization]\nspacing = 0.012\n"
                                       "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\n[[fixed]]\nshape = \"half-space\"\n"
                                       "point = [0, 0, 0.0001]\nnormal = [0, 0, 1]\n[tool]\nshape = \"sphere\"\nradius = 0.01\nposition = [0, 0, 0.035]\n");
  FitOptions options;
  options.scene = folder.write("refined.toml",
                               "[organ]\nsolid = \"box\"\nsize = [0.06, 0.06, 0.03]\n[discretization]\nspacing = 0.012\n"
                               "refine = [{ centre = [0, 0, 0.03], radius = 0.01, spacing = 0.006 }]\n"
                               "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\n[[fixed]]\nshape = \"half-space\"\n"
                               "point = [0, 0, 0.0001]\nnormal = [0, 0, 1]\n");
  CHECK_THAT(refusal([&] { fitCommand(options); }), Catch::Contains("leave the refinements out"));
  options.scene = scene;
  options.out = scene;
  CHECK_THAT(refusal([&] { fitCommand(options); }), Catch::Contains("this is the scene itself"));
}

TEST_CASE("A rate is held when few periods are missed and all but one in a thousand ticks are in time", "[fit]") {
  HeldRate held;
  held.ticks = 10000;
  held.overruns = 9;
  held.step_us.p999 = 1900;
  CHECK(held.held(500));
  CHECK_FALSE(held.held(1000));
  held.overruns = 11;
  CHECK_FALSE(held.held(500));
  held.overruns = 0;
  held.frozen = true;
  CHECK_FALSE(held.held(500));
}

TEST_CASE("A coarser reference counts for what it lacks", "[fit]") {
  ConvergedRun converged;
  converged.about.convergence.force = 0.03;
  CHECK(expectedError({0.04, 0}, converged, 2) == Approx(std::hypot(0.04, 0.01)));
  converged.about.convergence.force = 0;
  CHECK(expectedError({0.04, 0}, converged, 2) == Approx(0.04));
}

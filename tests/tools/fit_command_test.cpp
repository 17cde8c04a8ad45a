#include "mtled/fit/fit_command.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "io/load_model.h"
#include "io/scene_file.h"
#include "mtled/certify/certify_command.h"
#include "mtled/fit/fit_search.h"
#include "mtled/fit/rate_check.h"
#include "setup/place.h"
#include "support/block_text.h"
#include "support/interrupted_child.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::tools;
using namespace palpate::test;

namespace {

/// A body, a material and a tool drawn by lot: none that anything was tuned on.
Scene randomScene(unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * std::uniform_real_distribution<>()(random);
  };
  Scene scene;
  scene.name = "random " + std::to_string(seed);
  double top = 0;
  if (seed % 2 == 0) {
    scene.organs[0].solid = OrganSpec::Solid::Box;
    scene.organs[0].size = Vec3(between(0.05, 0.08), between(0.05, 0.08), between(0.025, 0.04));
    top = scene.organs[0].size.z();
  } else {
    scene.organs[0].solid = OrganSpec::Solid::Ellipsoid;
    scene.organs[0].upper_half = true;
    scene.organs[0].semi_axes = Vec3(between(0.03, 0.05), between(0.03, 0.05), between(0.03, 0.04));
    top = scene.organs[0].semi_axes.z();
  }
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", between(1000, 8000));
  scene.materials[0].material.set("poisson", between(0.4, 0.49));
  BoundarySpec base;
  base.region.kind = Region::Kind::HalfSpace;
  base.region.point = Vec3(0, 0, 1e-6);
  scene.boundaries.push_back(base);
  scene.tools[0].shape.radius = between(0.008, 0.012);
  scene.tools[0].position = Vec3(between(-0.01, 0.01), between(-0.01, 0.01), top + 0.002);
  scene.discretization.spacing = between(0.0075, 0.009);
  scene.dynamics.damping = 60;
  return scene;
}

}  // namespace

// A minute of work: a ctest of its own, not under sanitizers (tests/CMakeLists.txt).
TEST_CASE(
    "In nine of ten scenes drawn by lot fit expects the force error within a factor of two, and certify bounds it "
    "within four",
    "[.][random_scenes]") {
  int within = 0, certified = 0, drawn = 0;
  const auto quiet = [](double, const std::string&) {};
  for (const unsigned seed : {11U, 12U, 14U}) {
    const Scene scene = randomScene(seed);
    const Model model = loadModel(scene);
    const ToolTrajectory way = scriptedTrajectory(model);
    const auto probes = surfaceProbes(model, 50);
    const std::vector<ContactRegion> places = contactRegions(model, way);
    const TempFolder folder;
    FitRecord record(folder.path("record.json"), "");
    const FitTask task{scene, way, probes, 1, record, quiet};
    // As fit does, with even nodes and with nodes dense where the tool works ...
    const auto families = fitFamilies(scene, places);
    const FitFamily &even = families.front(),
                    &refined = *std::find_if(families.begin(), families.end(),
                                             [](const FitFamily&f) { return f.inside == 0.6; });
    const FitCandidate candidates[] = {tried(task, even, 1), tried(task, refined, 1.2)};
    const double inside = 1.2 * refined.inside;
    const Fineness fineness = fitFineness(1, inside);
    const ConvergedRun converged = convergedRun(model, way, probes, places, fineness, 1, quiet);
    // ... and against a solution finer than what fit compares with.
    const ConvergedRun finer =
        convergedRun(model, way, probes, places, {0.95 * fineness.outside, 0.78 * fineness.inside, 1.35}, 1, quiet);
    for (const FitCandidate& c : candidates) {
      REQUIRE(c.run.sound());
      const double expected = expectedError(errorOf(c.run, converged.run), converged, fineness.coarser).force,
                   measured = errorOf(c.run, finer.run).force;
      CAPTURE(seed, c.family, c.nodes, converged.about.nodes, finer.about.nodes, expected, measured,
              converged.about.convergence.force);
      CHECK(measured > 0);
      CHECK(expected < 3 * measured);
      CHECK(expected > measured / 3);
      // What certify would say of this cloud against the limit of the finer one, whose own is not known better than so.
      const Certificate::Row stated = certifiedRows(advances(model, way), c.run, converged, fineness.coarser, 1).at(0),
                             truth = certifiedRows(advances(model, way), c.run, finer, 1.35, 1).at(0);
      CAPTURE(stated.error, stated.uncertainty, truth.error, truth.uncertainty);
      CHECK(std::abs(stated.error - truth.error) < 2 * stated.uncertainty + truth.uncertainty);
      certified += truth.error < stated.bound() && stated.bound() < 4 * truth.error;
      ++drawn;
      within += expected < 2 * measured && expected > measured / 2;
    }
  }
  CHECK(drawn == 6);
  CHECK(within >= 5);
  CHECK(certified >= 5);
}

TEST_CASE("fit refuses what it can not fit, with what to do", "[fit]") {
  const TempFolder folder;
  const std::string scene = folder.write(
      "block.toml",
      "name = \"block\"\n[organ]\nsolid = \"box\"\nsize = [0.06, 0.06, 0.03]  # m\n[discretization]\nspacing = 0.012\n"
      "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\n[[fixed]]\nshape = \"half-space\"\n"
      "point = [0, 0, 0.0001]\nnormal = [0, 0, 1]\n[tool]\nshape = \"sphere\"\nradius = 0.01\nposition = [0, 0, "
      "0.035]\n");
  FitOptions options;
  options.scene = folder.write(
      "refined.toml",
      "[organ]\nsolid = \"box\"\nsize = [0.06, 0.06, 0.03]\n[discretization]\nspacing = 0.012\n"
      "refine = [{ centre = [0, 0, 0.03], radius = 0.01, spacing = 0.006 }]\n"
      "[[material]]\nmodel = \"neo-hookean\"\nyoung = 3000\npoisson = 0.45\n[[fixed]]\nshape = \"half-space\"\n"
      "point = [0, 0, 0.0001]\nnormal = [0, 0, 1]\n");
  CHECK_THAT(refusal([&] { fitCommand(options); }), Catch::Contains("leave the refinements out"));
  options.scene = scene;
  options.out = scene;
  CHECK_THAT(refusal([&] { fitCommand(options); }), Catch::Contains("this is the scene itself"));
}

TEST_CASE("A record of a fit gives back what was tried, and refuses another fit's or a damaged one", "[fit]") {
  const TempFolder folder;
  FitTry one;
  one.family = "support_factor 1.8";
  one.spacing_factor = 1.25;
  one.nodes = 500;
  one.points = 2000;
  one.substeps = 3;
  one.cost = {1000, 1500, 1800};
  one.run.force = {Vec3(0, 0, 1), Vec3(0, 0, 2.5)};
  one.run.probe_u = {Vec3(0, 0.25, 0)};
  one.run.min_J = 0.75F;
  const std::string file = folder.path("scene.fit.json");
  FitRecord record(file, "abc");
  CHECK_THAT(refusal([&] { record.resume(); }), Catch::Contains("nothing to resume"));
  record.add(one);
  one.family = "support_factor 2.2";
  record.add(one);

  FitRecord back(file, "abc");
  back.resume();
  const FitTry* found = back.find("support_factor 1.8", 1.25);
  REQUIRE(found != nullptr);
  CHECK(found->nodes == 500);
  CHECK(found->substeps == 3);
  CHECK(found->cost.tick_p999 == 1800);
  CHECK(found->run.force[1].z() == 2.5);
  CHECK(found->run.probe_u[0].y() == 0.25);
  CHECK(found->run.sound());
  CHECK(back.find("support_factor 2.2", 1.25) != nullptr);
  CHECK(back.find("support_factor 1.8", 1.3) == nullptr);

  FitRecord other(file, "abd");
  CHECK_THAT(refusal([&] { other.resume(); }), Catch::Contains("another scene"));
  for (const char* damaged : {"{}", "{\"identity\": \"abc\", \"tries\": [{}]}", "{\"identity\""}) {
    folder.write("scene.fit.json", damaged);
    CHECK_THAT(refusal([&] { back.resume(); }), Catch::Contains("damaged"));
  }
}

TEST_CASE("What a fit has tried is not tried again, and the finest that fits is found", "[fit]") {
  const TempFolder folder;
  Scene scene = blockScene();
  scene.dynamics.rate_hz = 500;
  const Model model = loadModel(scene);
  const ToolTrajectory way = scriptedTrajectory(model);
  const auto probes = surfaceProbes(model, 10);
  FitRecord record(folder.path("record.json"), "abc");
  int tries = 0;
  const FitTask task{scene, way, probes, 1, record, [&](double, const std::string&) { ++tries; }};
  const auto family = fitFamilies(scene, {}).front();
  // As if measured: time goes with the power of the spacing that the search expects, and 1 ms is all there is.
  FitTry one;
  one.family = family.name;
  one.nodes = 100;
  one.run.force = {Vec3(0, 0, 1)};
  double factor = 1;
  for (int k = 0; k < 5; ++k) {
    one.spacing_factor = factor;
    one.cost.tick_p50 = 4000 / std::pow(factor, 3.5);
    record.add(one);
    if (one.cost.tick_p50 <= 1000) break;
    factor *= std::pow(one.cost.tick_p50 / 930, 1 / 3.5);
  }
  const FitCandidate best = finestWithin(task, family, 0.5);
  CHECK(best.spacing_factor == Approx(factor));
  CHECK(best.scene.discretization.spacing == Approx(factor * scene.discretization.spacing));
  CHECK(best.cost.tick_p50 <= 1000);
  CHECK(tries == 2);

  FitRecord empty(folder.path("empty.json"), "abc");
  const FitTask fresh{scene, way, probes, 1, empty, [](double, const std::string&) {}};
  const FitCandidate run = tried(fresh, family, 1.2);
  CHECK(run.run.sound());
  CHECK(run.nodes > 0);
  CHECK(empty.find(family.name, 1.2) != nullptr);
}

TEST_CASE(
    "Families differ in name and scene, are refined only where a tool works, and add mass only beyond the scene's own",
    "[fit]") {
  Scene scene = blockScene();
  const std::vector<ContactRegion> places{{Vec3(0, 0, 0.03), 0.02}};
  const auto families = fitFamilies(scene, places);
  std::vector<Scene> turned;
  for (const auto& family : families) {
    turned.push_back(scene);
    family.turn(turned.back());
    CHECK(turned.back().discretization.refine.size() == (family.inside < 1 ? 1U : 0U));
    if (family.inside < 1)
      CHECK(turned.back().discretization.refine[0].spacing == Approx(family.inside * scene.discretization.spacing));
    for (const auto& other : families) CHECK((&other == &family || other.name != family.name));
  }
  CHECK(turned.front().discretization.refine.empty());
  CHECK(turned.front().dynamics.mass_scaling == 0);
  CHECK(turned.back().dynamics.mass_scaling > 0);
  for (const auto& family : fitFamilies(scene, {})) CHECK(family.inside == 1);
  scene.dynamics.mass_scaling = 0.2;
  for (const auto& family : fitFamilies(scene, places)) {
    Scene one = scene;
    family.turn(one);
    CHECK(one.dynamics.mass_scaling == 0.2);
  }
}

TEST_CASE("Where the cloud follows, the spacing near the tool is what a fit searches and writes", "[fit]") {
  const TempFolder folder;
  FitOptions options;
  options.scene = folder.write("block.toml", replaced(touched_block_text, "spacing = 0.012", "follow = true"));
  options.out = folder.path("fitted.toml");
  options.json = folder.path("fitted.json");
  options.cores = 2;
  options.rate_hz = 100;
  Scene scene = readScene(options.scene);
  const double by_tool = fineSpacing(scene);
  CHECK(fitFamilies(scene, {}).size() == 1);  // no more mass is added than the scene's own
  scene.dynamics.mass_scaling = 0;
  CHECK(fitFamilies(scene, {{Vec3(0, 0, 0.03), 0.02}}).size() == 2);  // nothing is refined by hand
  scaleSpacing(scene, 1.5);
  CHECK(fineSpacing(scene) == Approx(1.5 * by_tool));

  const Model model = loadModel(readScene(options.scene));
  const ToolTrajectory way = scriptedTrajectory(model);
  const auto probes = surfaceProbes(model, 10);
  FitRecord record(folder.path("record.json"), "");
  const Scene given = readScene(options.scene);
  const FitTask task{given, way, probes, 1, record, [](double, const std::string&) {}};
  const FitFamily family = fitFamilies(given, {}).front();
  const FitCandidate wide = tried(task, family, 1.6), close = tried(task, family, 1);
  REQUIRE((wide.run.sound() && close.run.sound()));
  CHECK(wide.nodes < 0.6 * close.nodes);
  CHECK(errorOf(wide.run, close.run).force > 0);
  CHECK(errorOf(wide.run, close.run).force < 0.2);

  const int code = fitCommand(options);
  REQUIRE(std::filesystem::exists(options.out));
  {
    const Scene fitted = readScene(options.out);
    std::ifstream in(options.json);
    const auto json = nlohmann::json::parse(in);
    CHECK(json.at("rate_held") == (code == 0));
    const std::string text = readAll(options.out);
    CHECK(text.starts_with("# Not confirmed: 100 Hz") == (code == 1));  // another program held the machine
    CHECK(json.at("expected_largest_force_error") > 0);
    CHECK(fitted.discretization.follow);
    CHECK(fineSpacing(fitted) == Approx(json.at("spacing_m").get<double>()).epsilon(1e-5));
    CHECK(fitted.dynamics.threads == 1);
    CHECK(json.at("follows") == true);
    CHECK(json.at("expected_force_error") > 0);
  }
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

TEST_CASE("An interrupted fit says how to go on, and goes on only with what is its own", "[fit]") {
  const TempFolder folder;
  FitOptions options;
  options.scene = folder.write("block.toml", touched_block_text);
  options.out = folder.path("fitted.toml");
  options.resume = true;
  CHECK_THAT(refusal([&] { fitCommand(options); }),
             Catch::Contains("fitted.fit.json") && Catch::Contains("nothing to resume"));
  folder.write("fitted.fit.json", "{\"identity\": \"0\", \"tries\": []}");
  CHECK_THAT(refusal([&] { fitCommand(options); }), Catch::Contains("another scene"));
  options.resume = false;
  std::filesystem::remove(folder.path("fitted.fit.json"));
  CHECK(codeWhenInterrupted(folder.path("fitted.fit.json"), [&] { return fitCommand(options); }) ==
        1);  // once something was tried
  CHECK_FALSE(std::filesystem::exists(options.out));
  std::ifstream in(folder.path("fitted.fit.json"));
  const auto json = nlohmann::json::parse(in);
  CHECK(json.at("tries").size() >= 1);
  CHECK(json.at("identity") != "0");
}

TEST_CASE("A coarser reference counts for what it lacks", "[fit]") {
  ConvergedRun converged;
  converged.about.convergence.force = 0.03;
  converged.about.convergence.loaded = 0.12;
  CHECK(expectedError({0.04, 0, 0.3}, converged, 2).force == Approx(std::hypot(0.04, 0.01)));
  CHECK(expectedError({0.04, 0, 0.3}, converged, 2).loaded == Approx(std::hypot(0.3, 0.04)));
  converged.about.convergence.force = 0;
  CHECK(expectedError({0.04, 0, 0.3}, converged, 2).force == Approx(0.04));
  converged.about.layer_error = 0.2;  // nor does the reference see all of a thin layer
  CHECK(expectedError({0.04, 0, 0.3}, converged, 2).force == Approx(0.2));
}

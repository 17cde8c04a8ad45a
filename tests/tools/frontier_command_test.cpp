#include "mtled/frontier/frontier_command.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "io/csv_table.h"
#include "mtled/frontier/frontier_page.h"
#include "mtled/frontier/frontier_result.h"
#include "mtled/frontier/frontier_settings.h"
#include "mtled/run/converged_run.h"
#include "support/block_text.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::tools;
using namespace palpate::test;

namespace {

FrontierRow row(const char* name, double cost, double error) {
  FrontierRow r;
  r.group = "spacing";
  r.name = name;
  r.nodes = 100;
  r.points = 500;
  r.substeps = 2;
  r.dt = 1e-3;
  r.cost = {cost, 2 * cost, 3 * cost};
  r.realtime_factor = 1000 / cost;
  r.error = {error, error / 2};
  r.peak_force = 0.3;
  return r;
}

Frontier madeUp() {
  Frontier f;
  f.scene = "made up";
  f.way = "built-in indentation";
  f.identity = "0123";
  f.rate_hz = 500;
  f.reference = {4000, 20000, 0.31, 2000, {0.01, 0.02}};
  f.rows = {row("as it is", 600, 0.05), row("cheap", 200, 0.2), row("worse and dearer", 700, 0.06),
            row("lost", 100, NAN)};
  f.rows.back().trouble = "blew up after 3 ticks";
  return f;
}

}  // namespace

TEST_CASE("The best rows are those that none beats in both, and none without an error", "[frontier]") {
  CHECK(bestRows(madeUp()) == std::vector<int>{1, 0});
}

TEST_CASE("A frontier comes back from its JSON, and damaged JSON is told", "[frontier]") {
  const Frontier f = madeUp(), back = frontierFromJson(jsonOf(f));
  CHECK(jsonOf(back) == jsonOf(f));
  CHECK(std::isnan(back.rows.back().error.force));
  CHECK(back.rows.back().trouble == f.rows.back().trouble);
  const std::string text = jsonOf(f);
  CHECK_THROWS_AS(frontierFromJson(text.substr(0, text.size() / 2)), std::runtime_error);
  CHECK_THROWS_AS(frontierFromJson("{}"), std::runtime_error);
}

TEST_CASE("Errors are measured against the better run's largest force and displacement, and its loaded ticks' own",
          "[frontier]") {
  ScriptedRun better, run;
  better.force = {Vec3::Zero(), Vec3(0, 0, 1), Vec3(0, 0, 2)};
  better.probe_u = {Vec3(0, 0, -0.01), Vec3::Zero()};
  run = better;
  CHECK(errorOf(run, better).force == 0);
  CHECK(errorOf(run, better).displacement == 0);
  run.force[0] = Vec3(0, 0, 9);  // before the contact: not counted
  run.force[2] = Vec3(0, 0, 2.2);
  run.probe_u[1] = Vec3(0.001, 0, 0);
  CHECK(errorOf(run, better).force == Approx(0.2 / std::sqrt(2.0) / 2));
  CHECK(errorOf(run, better).displacement == Approx(0.1 / std::sqrt(2.0)));
  CHECK(errorOf(run, better).loaded == Approx(0.1));
  run.force[1] = Vec3(0, 0.3, 1);  // half of the largest
  CHECK(errorOf(run, better).loaded == Approx(0.3));
  better.force[1] = Vec3(0, 0, 0.9);  // less
  CHECK(errorOf(run, better).loaded == Approx(0.1));
  run.force.pop_back();
  CHECK(std::isnan(errorOf(run, better).force));  // it ended early
}

TEST_CASE("A force trembles that jumps from tick to tick while the tool stands, not one that relaxes", "[frontier]") {
  constexpr int moving = 20, standing = 40;
  ToolTrajectory way;
  ScriptedRun relaxes, trembles;
  for (int k = 0; k < moving + standing; ++k) {
    way.emplace_back()[0].pose.position.z() = -1e-4 * std::min(k, moving);
    const double force = k < moving ? 1e-2 * k * k : 4 - 0.5 * (k - moving) / standing;
    relaxes.force.emplace_back(0, 0, force);
    trembles.force.emplace_back(0, 0, force + (k % 2 == 0 ? 0.04 : -0.04));
  }
  CHECK(trembleOf(relaxes, way) < 1e-9);
  CHECK(trembleOf(trembles, way) == Approx(0.04 * 4 / std::sqrt(6) / 4.04).epsilon(0.01));
  CHECK(trembleOf(trembles, way) > largest_tremble);
  way.resize(moving + 5);
  trembles.force.resize(moving + 5);
  CHECK(trembleOf(trembles, way) == 0);  // it moves, or hardly stands
}

TEST_CASE("Each setting turns something, has a name of its own, and the first is the scene as it is", "[frontier]") {
  const Scene scene = blockScene();
  const std::vector<ContactRegion> places{{Vec3(0, 0, 0.03), 0.02}};
  for (const bool quick : {false, true}) {
    const auto settings = frontierSettings(scene, places, quick, 2);
    REQUIRE(settings.size() > 10);
    CHECK(settings.front().group == "present");
    for (std::size_t a = 0; a < settings.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) CHECK(settings[a].name != settings[b].name);
    for (const auto& s : settings)
      if (s.group == "refined at the tool") {
        Scene turned = scene;
        s.turn(turned);
        CHECK(turned.discretization.spacing > scene.discretization.spacing);
        REQUIRE(turned.discretization.refine.size() == 1);
        CHECK(turned.discretization.refine[0].spacing < turned.discretization.spacing);
      }
  }
}

TEST_CASE("The place that a tool works on is found from its way", "[frontier]") {
  const Model model = blockModel();
  ToolTrajectory way = scriptedTrajectory(model);
  REQUIRE(contactRegions(model, way).size() == 1);
  const ContactRegion place = contactRegions(model, way).front();
  CHECK((place.centre - Vec3(0, 0, 0.03)).norm() < 0.006);
  CHECK(place.radius >= 2 * model.scene.tools[0].shape.radius);
  CHECK(place.radius < 4 * model.scene.tools[0].shape.radius);
  for (auto& tools : way) tools[0].pose.position.z() += 1;
  CHECK(contactRegions(model, way).empty());
}

TEST_CASE("A refined reference is closer to a finer one than the block as it is - doubles agree with floats",
          "[frontier]") {
  const Model model = blockModel();
  const ToolTrajectory way = scriptedTrajectory(model);
  const auto probes = surfaceProbes(model, 20);
  const ScriptedRun run = runTrajectory(model, way, probes, 1), in_double = runTrajectory(model, way, probes, 1, true);
  REQUIRE(run.sound());
  CHECK(run.tick_us.size() == way.size());
  CHECK(errorOf(run, in_double).force < 1e-3);
  CHECK(errorOf(run, in_double).displacement < 1e-4);
  const ConvergedRun converged =
      convergedRun(model, way, probes, contactRegions(model, way), {1, 0.6, 1.3}, 1, [](double, const std::string&) {});
  CHECK(converged.about.nodes > model.nodeCount());
  CHECK(converged.about.convergence.force < errorOf(run, converged.run).force);

  const TempFolder folder;
  const std::string file = folder.path("reference.json");
  writeConvergedRun(file, converged, "abc");
  ConvergedRun back;
  CHECK_FALSE(readConvergedRun(file, "abd", back));
  REQUIRE(readConvergedRun(file, "abc", back));
  CHECK(errorOf(run, back.run).force == errorOf(run, converged.run).force);
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    std::stringstream text;
    text << in.rdbuf();
    bytes = text.str();
  }
  folder.write("reference.json", bytes.substr(0, bytes.size() / 2));
  CHECK_FALSE(readConvergedRun(file, "abc", back));
}

TEST_CASE("What uniform nodes would cost follows a power law through the rows of the spacing", "[frontier]") {
  Frontier f = madeUp();
  f.rows = {row("as it is", 1000, 0.04), row("spacing x 2", 100, 0.16), row("elsewhere", 1, 0.01)};
  f.rows[0].group = "present";
  f.rows[2].group = "precision";
  CHECK(uniformCostAt(f, 0.04) == Approx(1000));
  CHECK(uniformCostAt(f, 0.08) == Approx(std::sqrt(1e5)));  // half way on both logarithmic scales
  CHECK(uniformCostAt(f, 0.02) == Approx(1000 * std::sqrt(10)));
  f.rows.pop_back();
  f.rows.back().error.force = NAN;
  CHECK(std::isnan(uniformCostAt(f, 0.04)));
}

TEST_CASE("The frontier's page has every setting, the picture and what refinement buys", "[frontier]") {
  Frontier f = madeUp();
  f.rows[0].group = "present";
  f.rows.erase(f.rows.begin() + 2);
  FrontierRow refined = row("outside x 2, inside x 0.7", 100, 0.05);
  refined.group = "refined at the tool";
  f.rows.push_back(refined);
  const TempFolder folder;
  writeFrontierPage(folder.path("page"), "mtled frontier made_up", f);
  std::ifstream in(folder.path("page/README.md"));
  std::stringstream page;
  page << in.rdbuf();
  for (const auto& r : f.rows) CHECK_THAT(page.str(), Catch::Contains(r.name));
  CHECK_THAT(page.str(), Catch::Contains("mtled frontier made_up") &&
                             Catch::Contains(withoutPictures().empty() ? "](frontier.png)" : withoutPictures()) &&
                             Catch::Contains("blew up after 3 ticks"));
  // "as it is" costs 600 at the same error of 0.05.
  CHECK_THAT(page.str(), Catch::Contains("| outside x 2, inside x 0.7 | 100 | 5.00 % | 100 | 600 | 6.0 |"));
  CHECK(std::ifstream(folder.path("page/frontier.png")).good() == withoutPictures().empty());
  CHECK(std::ifstream(folder.path("page/results.json")).good());
}

TEST_CASE("Nothing to resume, or something of another scene, is refused", "[frontier]") {
  const TempFolder folder;
  FrontierOptions options;
  options.scene = folder.write("block.toml", touched_block_text);
  options.out = folder.path("out");
  options.resume = true;
  CHECK_THAT(refusal([&] { frontierCommand(options); }), Catch::Contains("nothing to resume"));
  folder.write("out/frontier.json", jsonOf(madeUp()));
  CHECK_THAT(refusal([&] { frontierCommand(options); }), Catch::Contains("another scene"));
}

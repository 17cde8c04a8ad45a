// The loop with several tools and jaws: hands, scripts, recordings.

#include <algorithm>
#include <catch2/catch.hpp>

#include "io/output_file.h"
#include "model/model_hash.h"
#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/recording/force_csv.h"
#include "realtime/recording/recording_file.h"
#include "step/tool_bodies.h"
#include "support/realtime_guard.h"
#include "support/strip_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr int run_ticks = 120;

/// The strip's model; its table follows a script: down by 1 mm, evenly, in 50 ticks.
const Model& strip() {
  static const Model model = [] {
    Model made = stripModel();
    for (int k = 1; k <= 50; ++k) {
      ToolPosture table = made.tools.tool[1].start;
      table.pose.position.z() -= 2e-5 * k;
      made.tools.tool[1].path.push_back(table);
    }
    return made;
  }();
  return model;
}

/// Closes the jaws, resets in between, and takes the table from its script.
void play(SimulationLoop& loop) {
  for (int k = 0; k < run_ticks; ++k) {
    if (k == 5) loop.toolHands().opening[0] = 0.005;
    if (k == 60) loop.commands().push(Request::simple(Request::Kind::Reset));
    if (k == 70) loop.toolHands().opening[0] = 0.006;
    if (k == 80) {
      Pose table = strip().tools.tool[1].start.pose;
      table.position.x() += 0.001;
      loop.toolHands().further[0].back().pose = table;
      loop.toolHands().further[0].publish();
    }
    loop.advanceHere(1);
  }
}

}  // namespace

TEST_CASE("A recorded run with jaws and a second tool is replayed bit for bit", "[several_tools][whole]") {
  TissuePhysics physics(strip(), 1);
  SimulationLoopOptions options;
  options.record = true;
  SimulationLoop loop(strip(), physics, &physics.team(), options);
  startGuard();
  play(loop);
  CHECK(stopGuard().total() == 0);
  const ToolReadings last = loop.toolReadings();
  REQUIRE(last.count == 2);
  CHECK(last.tick == run_ticks);
  CHECK(last.tool[0].opening == Approx(0.006).margin(1e-9));
  CHECK(last.tool[0].pinch > 0.01);                           // N
  CHECK(last.tool[1].pose[0] == Approx(0.001).margin(1e-9));  // a hand took it over
  CHECK(last.tool[1].pose[2] == Approx(strip().tools.tool[1].start.pose.position.z()));

  Recording recording{"strip", modelHash(strip()), strip().scene.dynamics.rate_hz, run_ticks, {}};
  for (TimedRequest change; loop.recorded().pop(change);) recording.changes.push_back(change);
  const TempFolder folder;
  writeWholeFile(folder.path("run.txt"), toText(recording));
  const Recording read = readRecording(folder.path("run.txt"));
  REQUIRE(read.changes.size() == recording.changes.size());

  TissuePhysics again(strip(), 2);
  SimulationLoopOptions replay;
  replay.track = read.changes;
  replay.track_ticks = read.ticks;
  SimulationLoop replayed(strip(), again, &again.team(), replay);
  replayed.advanceHere(run_ticks);
  CHECK(again.stateHash() == physics.stateHash());
  CHECK(replayed.toolReadings().tool[0].pinch == last.tool[0].pinch);
}

TEST_CASE("A tool with a script follows it from the start and after a reset, and then stays",
          "[several_tools][whole]") {
  TissuePhysics physics(strip(), 1);
  SimulationLoop loop(strip(), physics, &physics.team(), {});
  const double z = strip().tools.tool[1].start.pose.position.z();
  const auto table = [&] { return loop.toolReadings().tool[1].pose[2]; };
  loop.advanceHere(10);
  CHECK(table() == Approx(z - 2e-4));
  loop.commands().push(Request::simple(Request::Kind::Reset));
  loop.advanceHere(1);
  CHECK(table() == Approx(z - 2e-5));
  loop.advanceHere(80);
  CHECK(table() == Approx(z - 1e-3));

  // Forces and readings come in pairs, and the columns of force.csv are as many as its header says.
  const ForceColumns columns(strip());
  ForceSample sample;
  ToolReadings readings;
  int pairs = 0;
  std::string row;
  while (loop.forces().pop(sample)) {
    REQUIRE(loop.tools().pop(readings));
    REQUIRE(readings.tick == sample.tick);
    row = forceCsvRow(sample, readings, columns);
    ++pairs;
  }
  CHECK(pairs == 91);
  const std::string header = forceCsvHeader(columns);
  CHECK(std::count(row.begin(), row.end(), ',') == std::count(header.begin(), header.end(), ','));
  CHECK(header.find("tool1_opening_m,tool1_pinch_N,tool2_x_m") != std::string::npos);
  CHECK(forceCsvHeader({}) == force_csv_header);
}

TEST_CASE("Jaws stop at the grip force that the scene gives them", "[several_tools][whole]") {
  Scene scene = stripScene();
  scene.tools[0].grip_force = 0.02;  // N
  const Model model = stripModel(scene);
  TissuePhysics physics(model, 1);
  SimulationLoop loop(model, physics, &physics.team(), {});
  loop.toolHands().opening[0] = 0.001;
  double largest = 0;
  for (int k = 0; k < 150; ++k) {
    loop.advanceHere(1);
    if (k >= 100) largest = std::max(largest, loop.toolReadings().tool[0].pinch);
  }
  CHECK(largest > 0.01);
  CHECK(largest < 0.022);
  CHECK(loop.toolReadings().tool[0].opening > 0.002);
}

TEST_CASE("Jaws that close on a strip hold it at their grip force, and it follows the hand that lifts them",
          "[several_tools][whole]") {
  const Model model = stripModel();
  const double grip = model.tools.first().grip_force;
  REQUIRE(0.8 * 2 * grip > 2 * stripWeight(model));  // by friction, and then some
  TissuePhysics physics(model, 1);
  SimulationLoop loop(model, physics, &physics.team(), {});
  double largest = 0, least = grip;
  const auto run = [&](int ticks, double up, double opening, bool held) {
    for (int k = 1; k <= ticks; ++k) {
      Pose hand = model.tools.first().start.pose;
      hand.position.z() += up * k / ticks;
      loop.hand().back() = {hand, 1};
      loop.hand().publish();
      loop.toolHands().opening[0] = opening;
      loop.advanceHere(1);
      const double pinch = loop.toolReadings().tool[0].pinch;
      largest = std::max(largest, pinch);
      if (held) least = std::min(least, pinch);
    }
  };
  run(100, 0, 0.012, false);  // it comes to stand on the table
  run(400, 0, 0, false);      // the hand closes them whole
  run(500, 0.01, 0, true);
  const ToolReading jaws = loop.toolReadings().tool[0];
  INFO("grip " << grip << " N, pinch " << least << " to " << largest << " N, " << 1e3 * jaws.opening
               << " mm open, min J " << loop.summary().min_J << ", yields " << 1e3 * loop.summary().largest_yield
               << " mm");
  CHECK(largest <= 1.001 * grip);
  CHECK(least > 0.85 * grip);
  CHECK(jaws.opening > 0.002);
  CHECK(loop.summary().min_J > 0.5F);
  CHECK(loop.summary().trust.doubt() <= Doubt::Resolution);
  CHECK(jaws.pose[2] == Approx(model.tools.first().start.pose.position.z() + 0.01).margin(1e-9));
  CHECK(loop.toolReadings().tool[1].contact_count == 0);  // it hangs
}

TEST_CASE("What a recording says of a tool that can't be is refused at its line", "[several_tools]") {
  const TempFolder folder;
  const auto read = [&](const std::string& change) {
    readRecording(folder.write(
        "r.txt", "palpate-recording 3\nscene a\nmodel 0123456789abcdef\nrate_hz 500\n" + change + "\nend 9\n"));
  };
  const auto problem = [&](const std::string& change) { return refusal([&] { read(change); }); };
  CHECK_NOTHROW(read("1 hand 1 0 0 0 1 0 0 0"));
  CHECK_NOTHROW(read("1 opening 0 0.01"));
  CHECK_THAT(problem("1 hand 0 0 0 0 1 0 0 0"), Catch::Contains("r.txt:5:8: there is no such tool"));
  CHECK_THAT(problem("1 hand 4 0 0 0 1 0 0 0"), Catch::Contains("there is no such tool"));
  CHECK_THAT(problem("1 opening 0 wide"), Catch::Contains("is not an opening, m"));
}

#include "realtime/device/coupled_tool.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"
#include "support/strip_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

void pull(CoupledTool& tool, const Vec3& to, double stiffness, bool engaged = true) {
  DeviceTarget& target = tool.targets().back();
  target.engaged = engaged;
  target.pose.position = to;
  target.stiffness = stiffness;
  ++target.sequence;
  tool.targets().publish();
}

}  // namespace

TEST_CASE("The tool rests where the coupling's spring carries what the tissue does, however stiff that is",
          "[device]") {
  const Model model = smallModel(1000);
  const double stiffness = 400;
  for (const double tissue : {10.0, 400.0, 4000.0}) {
    CAPTURE(tissue);
    CoupledTool tool(model);
    REQUIRE(stiffness + 2 * tool.normalHold() > tissue);  // where the steps converge
    State state;
    StepReport last;
    state.tool[0].pose.position = Vec3(0, 0, 0.001);
    for (int k = 0; k < 2000; ++k) {
      pull(tool, Vec3(0.003, 0, -0.01), stiffness);
      state.tool[0].pose = tool.next(state, last);
      const double z = state.tool[0].pose.position.z();
      last.tool_force = Vec3(0, 0, std::max(0.0, -tissue * z));
      last.contact_normal = Vec3::UnitZ();
    }
    const double expected = -0.01 * stiffness / (stiffness + tissue);
    CHECK(state.tool[0].pose.position.z() == Approx(expected).epsilon(1e-9));
    CHECK(state.tool[0].pose.position.x() == Approx(0.003));  // without friction nothing holds it along the skin
  }
}

TEST_CASE("A tool in coarse tissue does not go to and fro from tick to tick", "[device]") {
  const Model model = blockModel();  // without friction
  REQUIRE(model.scene.tools[0].friction == 0);
  CoupledTool tool(model);
  State state = initialState(model);
  Workspace workspace(model, 1);
  StepReport last;
  Command command;
  constexpr double stiffness = 80;  // N/m: what a slow line to a light device leaves
  constexpr int press = 200, hold = 150, watched = 40;
  const double depth = model.tools.first().first_contact_travel + 0.6 * model.scene.tools[0].shape.radius;
  Vec3 hand;
  double largest = 0;  // m in a tick
  for (int k = 1; k <= press + hold; ++k) {
    hand = toolAt(model, depth * std::min(1.0, static_cast<double>(k) / press), 2e-4).position;
    pull(tool, hand, stiffness);
    command.tools[0].pose = tool.next(state, last);
    if (k > press + hold - watched)
      largest = std::max(largest, (command.tools[0].pose.position - state.tool[0].pose.position).norm());
    last = tick(model, state, command, workspace);
  }
  CHECK(largest < 1e-5);             // it was 2.5e-4, and the force came and went with it
  CHECK(last.tool_force.z() > 0.1);  // N
  CHECK(stiffness * (state.tool[0].pose.position - hand).norm() == Approx(last.tool_force.norm()).epsilon(0.02));
}

TEST_CASE("What a rattle shows is believed up to a bound, and forgotten", "[device]") {
  RattleWatch watch;
  const Vec3 way(0, 0, 1e-4), answer(0, 0, -0.3);  // m, N: 3000 N/m
  constexpr double tick_s = 0.002;
  for (int k = 0; k < 5; ++k) CHECK(watch.see(way, answer, 1e4, tick_s) == 0);  // it goes one way
  double seen = 0;
  for (int k = 0; k < 4; ++k)
    seen = watch.see(k % 2 == 0 ? Vec3(-way) : way, k % 2 == 0 ? Vec3(-answer) : answer, 1e4, tick_s);
  CHECK(seen == Approx(3000));
  CHECK(watch.see(-way, -answer, 2000, tick_s) == Approx(2000));
  for (int k = 0; k < 2500; ++k) seen = watch.see(Vec3::Zero(), Vec3::Zero(), 1e4, tick_s);
  CHECK(seen < 0.01 * 3000);
  watch.forget();
  CHECK(watch.see(way, answer, 1e4, tick_s) == 0);
}

TEST_CASE("In air the tool is where the device is - without a device it stays", "[device]") {
  const Model model = smallModel();
  CoupledTool tool(model);
  State state;
  state.tool[0].pose.position = Vec3(0.1, 0.2, 0.3);
  CHECK(tool.next(state, {}).position == state.tool[0].pose.position);
  pull(tool, Vec3(0.5, 0, 0), 400);
  CHECK(tool.next(state, {}).position == Vec3(0.5, 0, 0));
  CHECK(tool.poseSequence() == 1);
  pull(tool, Vec3(0.6, 0, 0), 400, false);
  CHECK(tool.next(state, {}).position == state.tool[0].pose.position);
  CHECK(tool.poseSequence() == 1);
}

TEST_CASE("A device's run is recorded and replayed without the device, bit for bit", "[device]") {
  const Model model = smallModel();
  FakePhysics physics(model), again(model);
  CoupledTool tool(model);
  SimulationLoopOptions options;
  options.device = &tool;
  options.record = true;
  SimulationLoop loop(model, physics, nullptr, options);
  constexpr int ticks = 300;
  const std::vector<Pose> hand = wander(ticks, 5);
  for (int k = 0; k < ticks; ++k) {
    if (k % 3 != 1) pull(tool, hand[static_cast<std::size_t>(k)].position, 400);
    loop.advanceHere(1);
    CHECK(loop.force().sample.pose_sequence > 0);
  }
  SimulationLoopOptions replay = limited(ticks);
  replay.track = drain(loop.recorded());
  REQUIRE(replay.track.size() > 100);
  SimulationLoop second(model, again, nullptr, replay);
  second.advanceHere(ticks);
  CHECK(again.stateHash() == physics.stateHash());
  CHECK(again.state().tool[0].pose.position == physics.state().tool[0].pose.position);
}

TEST_CASE("A device's button closes jaws while it is down - a replay has the same openings", "[device][tools]") {
  Scene scene = stripScene();
  scene.dynamics.gravity.setZero();
  scene.tools.resize(1);
  scene.tools[0].opening = 0.009;
  const Model model = stripModel(scene);
  const ToolPosture start = model.tools.first().start;
  const double step = jaw_speed / model.scene.dynamics.rate_hz;
  TissuePhysics physics(model, 1), again(model, 1);
  CoupledTool tool(model);
  SimulationLoopOptions options;
  options.device = &tool;
  options.record = true;
  SimulationLoop loop(model, physics, &physics.team(), options);
  int ticks = 0;
  const auto openingAfter = [&](bool closes, int more) {
    for (int k = 0; k < more; ++k, ++ticks) {
      tool.targets().back().closes = closes;
      pull(tool, start.pose.position, 400);
      loop.advanceHere(1);
    }
    return physics.state().tool[0].opening;
  };
  CHECK(openingAfter(false, 5) == start.opening);
  CHECK(openingAfter(true, 60) == Approx(start.opening - 60 * step).epsilon(1e-9));
  CHECK(openingAfter(false, 20) == Approx(start.opening - 40 * step).epsilon(1e-9));
  CHECK(openingAfter(false, 60) == Approx(start.opening).epsilon(1e-9));
  const double held = openingAfter(true, 500);
  CHECK(held > 0.001);  // the strip is between them: no further
  CHECK(loop.toolReadings().tool[0].pinch > 0.01);
  CHECK(openingAfter(false, 5) > held + 3 * step);  // they open at once, from where they are
  SimulationLoopOptions replay = limited(ticks);
  replay.track = drain(loop.recorded());
  SimulationLoop second(model, again, &again.team(), replay);
  second.advanceHere(ticks);
  CHECK(again.stateHash() == physics.stateHash());
}

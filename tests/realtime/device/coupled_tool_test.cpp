#include "realtime/device/coupled_tool.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"

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
    state.tool_pose.position = Vec3(0, 0, 0.001);
    for (int k = 0; k < 2000; ++k) {
      pull(tool, Vec3(0.003, 0, -0.01), stiffness);
      state.tool_pose = tool.next(state, last);
      const double z = state.tool_pose.position.z();
      last.tool_force = Vec3(0, 0, std::max(0.0, -tissue * z));
      last.contact_normal = Vec3::UnitZ();
    }
    const double expected = -0.01 * stiffness / (stiffness + tissue);
    CHECK(state.tool_pose.position.z() == Approx(expected).epsilon(1e-9));
    CHECK(state.tool_pose.position.x() == Approx(0.003));  // without friction nothing holds it along the skin
  }
}

TEST_CASE("In air the tool is where the device is; without a device it stays", "[device]") {
  const Model model = smallModel();
  CoupledTool tool(model);
  State state;
  state.tool_pose.position = Vec3(0.1, 0.2, 0.3);
  CHECK(tool.next(state, {}).position == state.tool_pose.position);
  pull(tool, Vec3(0.5, 0, 0), 400);
  CHECK(tool.next(state, {}).position == Vec3(0.5, 0, 0));
  CHECK(tool.poseSequence() == 1);
  pull(tool, Vec3(0.6, 0, 0), 400, false);
  CHECK(tool.next(state, {}).position == state.tool_pose.position);
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
  CHECK(again.state().tool_pose.position == physics.state().tool_pose.position);
}

#include "realtime/loop/tool_goal.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "realtime/loop_run.h"
#include "setup/build_model.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("A way is gone evenly and ends exactly where it was asked to", "[tool_goal]") {
  ToolGoal goal(poseAt(Vec3(0, 0, 0.1)), 500);
  const Pose first = poseAt(Vec3(0.02, 0, 0.1), 0.4), second = poseAt(Vec3(0.02, 0, 0.05));
  goal.moveTo(first, 0.2);
  goal.thenMoveTo(second, 0.1);
  Vec3 before = goal.pose().position;
  for (int k = 1; k <= 150; ++k) {
    goal.advance();
    const double step = (goal.pose().position - before).norm();
    before = goal.pose().position;
    CHECK(step == Approx(k <= 100 ? 0.02 / 100 : 0.05 / 50).epsilon(1e-9));
    if (k == 100) {
      CHECK(goal.pose().position == first.position);
      CHECK(goal.pose().orientation.angularDistance(first.orientation) < 1e-12);
    }
  }
  CHECK(goal.pose().position == second.position);
  goal.advance();
  CHECK(goal.pose().position == second.position);
}

TEST_CASE("A steady motion has its speed and its turn, and ends by itself", "[tool_goal]") {
  ToolGoal goal(Pose{}, 500);
  goal.steer(Vec3(0, 0, -0.02), Vec3(0, 0.5, 0), 0.5);
  for (int k = 0; k < 1000; ++k) goal.advance();
  CHECK(goal.pose().position.z() == Approx(-0.01).epsilon(1e-9));
  CHECK(goal.pose().orientation.angularDistance(Quat::Identity()) == Approx(0.25).epsilon(1e-9));
  goal.steer(Vec3(1, 0, 0), Vec3::Zero(), 1);
  goal.steer(Vec3::Zero(), Vec3::Zero(), 1);
  const Vec3 stopped = goal.pose().position;
  goal.advance();
  CHECK(goal.pose().position == stopped);
}

namespace {

/// A key held for a second and a half, as a viewer that draws `pictures` a second hands it on; the hand's way.
std::vector<Vec3> wayOfHeldKey(int pictures, double speed) {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  SimulationLoop loop(model, physics, nullptr, limited(1100));
  FakeClock clock;
  std::vector<Vec3> way;
  const int every = 500 / pictures;
  clock.before_sleep = [&](int sleep) {
    way.push_back(loop.snapshots().latest().hand_pose.position);
    if (sleep % every != 0) return;
    const bool held = sleep >= 250 && sleep < 1000;
    loop.commands().push(Request::steer(held ? Vec3(0, 0, -speed) : Vec3::Zero(), Vec3::Zero(), 1.5 / pictures));
  };
  loop.run(clock);
  return way;
}

}  // namespace

TEST_CASE("A held key's speed is the tool's speed at 2 pictures a second as at 60", "[tool_goal]") {
  constexpr double speed = 0.02;
  for (const int pictures : {2, 10, 50}) {
    CAPTURE(pictures);
    const std::vector<Vec3> way = wayOfHeldKey(pictures, speed);
    double fastest = 0;
    for (std::size_t k = 1; k < way.size(); ++k) fastest = std::max(fastest, 500 * (way[k] - way[k - 1]).norm());
    CHECK(fastest <= speed * 1.001);
    CHECK(fastest >= speed * 0.999);
    CHECK((way.back() - way.front()).norm() == Approx(speed * 1.5).epsilon(0.01));
  }
}

TEST_CASE("Input that comes twice a second gives the force no steps", "[tool_goal]") {
  const Model model = blockModel(blockScene(0.015));
  // A key held for 0.6 s, then wheel notches and a drag in leaps of 1.5 mm every half second.
  TissuePhysics physics(model, 1);
  SimulationLoop loop(model, physics, nullptr, limited(1500));
  FakeClock clock;
  Pose target = model.tools.first().start.pose;
  clock.before_sleep = [&](int sleep) {
    if (sleep % 250 != 0) return;
    target = loop.snapshots().latest().goal_pose;
    if (sleep < 250) {
      loop.commands().push(Request::steer(Vec3(0, 0, -0.006), Vec3::Zero(), 0.6));
    } else {
      target.position.z() -= 0.0015 * (sleep < 1000 ? 1 : -1);
      loop.commands().push(Request::moveTool(target, 0.5));
    }
  };
  loop.run(clock);
  double peak = 0, largest = 0;
  Vec3 before = Vec3::Zero();
  for (const ForceSample& sample : drain(loop.forces())) {
    peak = std::max(peak, sample.force_raw.norm());
    largest = std::max(largest, (sample.force_raw - before).norm());
    before = sample.force_raw;
  }
  CHECK(peak > 0.1);
  CHECK(largest < 0.05 * peak);
}

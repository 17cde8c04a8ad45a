#include "realtime/device/device_coupling.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "realtime/fakes.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// A coupling called each millisecond with a handle and a tool where the test has them, in contact.
struct Hand {
  explicit Hand(const DeviceSettings& device = {}) : settings(device), model(test::smallModel(1000)) {
    tool.tick = 1;
    tool.contact_count = 1;
    tool.tool_pose = model.tool_start;
    call();  // the handle's first place is the tool's start
  }

  Vec3 call() {
    now += ms;
    if (follows) tool.wall_ns = now - 2 * ms;
    ++tool.tick;
    pose.sequence += 1;
    if (felt_ago > 0 && pose.sequence > felt_ago) pose.felt = pose.sequence - felt_ago;
    const Vec3 force = coupling.update(now, sends ? &pose : nullptr, tool, put_backs).force;
    largest_change = std::max(largest_change, (force - last).norm());
    return last = force;
  }
  Vec3 after(int calls_more) {
    for (int k = 0; k < calls_more; ++k) call();
    return last;
  }
  void moveTool(const Vec3& from_start) { tool.tool_pose.position = model.tool_start.position + from_start; }

  DeviceSettings settings;
  Model model;
  DeviceCoupling coupling{settings, model};
  std::int64_t now = 1000 * ms;
  DevicePose pose;
  ForceSample tool;
  bool sends = true, follows = true;
  std::uint32_t felt_ago = 0, put_backs = 0;
  Vec3 last = Vec3::Zero();
  double largest_change = 0;
};

}  // namespace

TEST_CASE("At rest the handle feels the coupling's spring, in air nothing", "[device]") {
  Hand hand;
  hand.pose.pose.position = Vec3(0.001, 0, -0.005);
  hand.moveTool(Vec3(0, 0, -0.002));
  hand.after(1000);
  CHECK((hand.last - 400 * Vec3(-0.001, 0, 0.003)).norm() < 1e-9);
  CHECK((hand.coupling.target().pose.position - hand.model.tool_start.position - hand.pose.pose.position).norm() <
        1e-15);
  CHECK(hand.coupling.target().stiffness == Approx(400));
  hand.tool.contact_count = 0;
  CHECK(hand.after(10) == Vec3::Zero());
}

TEST_CASE("A scaled way changes the spring that the tool feels, not the one that the hand does", "[device]") {
  DeviceSettings settings;
  settings.scale = 4;
  Hand hand(settings);
  hand.pose.pose.position = Vec3(0, 0, -0.002);
  hand.after(1000);
  CHECK((hand.last - 400 * Vec3(0, 0, 0.002)).norm() < 1e-9);
  CHECK(hand.coupling.target().stiffness == Approx(100));
  CHECK((hand.coupling.target().pose.position - hand.model.tool_start.position - Vec3(0, 0, -0.008)).norm() < 1e-15);
}

TEST_CASE("The force's norm is bounded, and how quickly it changes", "[device]") {
  Hand hand;
  hand.pose.pose.position = Vec3(-0.05, 0.05, -0.05);
  hand.after(1000);
  CHECK(hand.last.norm() == Approx(3.3));
  CHECK((hand.last.normalized() - Vec3(1, -1, 1).normalized()).norm() < 1e-12);
  hand.pose.pose.position *= -1;
  hand.after(200);
  CHECK(hand.largest_change <= 3.3 / 0.01 * 1e-3 * (1 + 1e-9));
  CHECK(hand.largest_change > 0.3);
}

TEST_CASE("A device that falls silent has no force 60 ms later, and begins from rest again", "[device]") {
  Hand hand;
  hand.pose.pose.position = Vec3(0, 0, -0.004);
  const Vec3 held = hand.after(1000);
  hand.sends = false;
  CHECK(hand.after(9) == held);
  CHECK(hand.coupling.target().engaged);
  const Vec3 fading = hand.after(20);
  CHECK(fading.norm() < 0.7 * held.norm());
  CHECK(fading.norm() > 0);
  CHECK_FALSE(hand.coupling.target().engaged);
  CHECK(hand.after(31) == Vec3::Zero());
  CHECK(hand.coupling.report().silences == 1);

  hand.after(140);
  hand.sends = true;
  hand.pose.pose.position = Vec3(0, 0, -0.008);  // it was pushed on meanwhile
  CHECK(hand.call().norm() < 1e-9);
  double largest = 0;
  for (int k = 0; k < 100; ++k) largest = std::max(largest, hand.call().norm());
  CHECK(largest < 400 * 0.008 * 0.3);  // a third of the way in time: 0.26 of it
  CHECK((hand.after(300) - Vec3(0, 0, 3.2)).norm() < 1e-9);
}

TEST_CASE("Tissue that was put back, is frozen or late fades the force", "[device]") {
  const auto spoil = GENERATE(0, 1, 2, 3, 4);
  Hand hand;
  hand.pose.pose.position = Vec3(0, 0, -0.004);
  const Vec3 held = hand.after(1000);
  CAPTURE(spoil);
  if (spoil == 0) ++hand.tool.loss_count;
  if (spoil == 1) hand.tool.frozen = true;
  if (spoil == 2) hand.follows = false;             // its force grows old
  if (spoil == 3) hand.moveTool(Vec3(0, 0, 0.05));  // a reset
  if (spoil == 4) ++hand.put_backs;                 // an undo
  hand.largest_change = 0;
  hand.after(60);
  CHECK(hand.coupling.report().fades == 1);
  CHECK(hand.largest_change < 0.03 * held.norm());  // 40 ms of fading: no jump, wherever the tool is now
  if (spoil == 1 || spoil == 2) {
    CHECK(hand.last == Vec3::Zero());
    hand.tool.frozen = false;
    hand.follows = true;
    CHECK(hand.call().norm() < 1e-9);
  }
  hand.after(1000);
  CHECK(hand.coupling.report().engaged);
  CHECK(hand.last.norm() == Approx(spoil == 3 ? 3.3 : held.norm()));
}

TEST_CASE("The passivity controller takes out the energy that a tool ahead of the hand puts in", "[device]") {
  const auto lowest = [](double own_damping) {
    DeviceSettings settings;
    settings.own_damping = own_damping;
    settings.damping = 0;
    settings.stiffness = 50;  // within what each own damping allows
    Hand hand(settings);
    double z = 0;
    for (int k = 0; k < 4000; ++k) {
      const double before = z;
      z = -0.01 * (1 - std::cos(0.02 * k));
      hand.pose.pose.position = Vec3(0, 0, z);
      // F = 1 N s/m times the velocity: a damper of the wrong sign
      hand.moveTool(Vec3(0, 0, z + (z - before) / 1e-3 / 50));
      hand.call();
    }
    return std::pair(hand.coupling.report().lowest_energy_J, hand.coupling.report().damped_J);
  };
  const auto [held, damped] = lowest(2);
  const auto [lost, nothing] = lowest(0.05);
  CHECK(held > -2e-4);
  CHECK(damped > 0);
  CHECK(lost < 20 * held);
}

TEST_CASE("A device that answers late gets the stiffness that its damping allows", "[device]") {
  DeviceSettings settings = DeviceSettings::of(1);
  Hand hand(settings);
  hand.after(2000);
  CHECK(hand.coupling.report().stiffness == Approx(3000));
  hand.felt_ago = 6;  // one period lies between a force and the next pose: 5 ms of way
  hand.after(2000);
  CHECK(hand.coupling.report().delay_s == Approx(0.005).epsilon(0.02));
  CHECK(hand.coupling.report().stiffness == Approx(2 / (0.0005 + 0.005)).epsilon(0.02));
}

TEST_CASE("A call of the coupling takes no memory and no lock", "[device]") {
  Hand hand;
  hand.pose.pose.position = Vec3(0, 0, -0.004);
  test::startGuard();
  hand.after(100);
  hand.sends = false;
  hand.after(100);
  hand.sends = true;
  hand.after(100);
  const test::GuardCounts counts = test::stopGuard();
  CHECK(counts.total() == 0);
  CHECK(hand.coupling.report().poses > 100);
}

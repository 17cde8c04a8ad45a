#include "realtime/device/simulated_device.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using namespace palpate;

namespace {

constexpr std::int64_t millisecond = 1'000'000;
constexpr HandModel no_hand{1, 0, 0, 0, 0};

/// A device without losses that nobody holds.
SimulatedDeviceSettings freeDevice() {
  SimulatedDeviceSettings device;
  device.damping = device.friction = 0;
  return device;
}

/// Calls each millisecond with a force. @return the poses that came
std::vector<DevicePose> run(SimulatedDevice& device, int calls, const Vec3& force) {
  std::vector<DevicePose> poses;
  DeviceWrench wrench;
  wrench.force = force;
  for (int k = 0; k < calls; ++k) {
    DevicePose pose;
    if (device.read(k * millisecond, pose)) poses.push_back(pose);
    ++wrench.sequence;
    device.write(k * millisecond, wrench);
  }
  return poses;
}

}  // namespace

TEST_CASE("A device that nobody holds falls as a mass does", "[device]") {
  SimulatedDevice device(freeDevice(), no_hand, {});
  run(device, 101, Vec3(0, 0, -1));
  CHECK(device.handle().z() == Approx(-0.5 * 1 / 0.05 * 0.1 * 0.1).epsilon(0.01));
  CHECK(device.work() == Approx(0.5 * 0.05 * 2 * 2).epsilon(0.01));  // its energy: 2 m/s
}

TEST_CASE("Friction holds the handle against what is weaker, and the motors push no more than they can", "[device]") {
  SimulatedDeviceSettings settings = freeDevice();
  settings.friction = 0.5;
  SimulatedDevice stuck(settings, no_hand, {}), slides(settings, no_hand, {});
  run(stuck, 100, Vec3(0.3, 0, 0.39));
  CHECK(stuck.handle() == Vec3::Zero());
  run(slides, 100, Vec3(0, 6, 8));
  CHECK(slides.force().norm() == Approx(settings.max_force));
  CHECK(slides.handle().norm() > 0.1);
}

TEST_CASE("Poses come in the encoder's steps, late and each once, the same for the same seed", "[device]") {
  SimulatedDeviceSettings settings = SimulatedDeviceSettings::of(1);
  settings.delay_s = 0.005;
  const auto poses = [&](std::uint64_t seed) {
    settings.seed = seed;
    HandMotion motion;
    motion.kind = HandMotion::Kind::Random;
    SimulatedDevice device(settings, HandModel::light(), motion);
    return run(device, 300, Vec3(0, 0, 0.5));
  };
  const auto first = poses(1), again = poses(1), other = poses(2);
  REQUIRE(first.size() > 100);
  REQUIRE(first.size() == again.size());
  std::uint32_t most_ago = 0;
  for (std::size_t k = 0; k < first.size(); ++k) {
    CHECK(first[k].pose.position == again[k].pose.position);
    const double steps = first[k].pose.position.z() / settings.encoder_step;
    CHECK(std::abs(steps - std::round(steps)) < 1e-6);
    if (k > 0) CHECK(first[k].sequence > first[k - 1].sequence);
    if (k > 50) most_ago = std::max(most_ago, first[k].sequence - first[k].felt);
  }
  CHECK(most_ago >= 2);  // forces take up to 2.5 ms, and up to a period until they are looked at
  CHECK(most_ago <= 4);
  bool differ = other.size() != first.size();
  for (std::size_t k = 0; !differ && k < first.size(); ++k) differ = other[k].sequence != first[k].sequence;
  CHECK(differ);
}

TEST_CASE("A hand that rests is pushed away as its arm's spring lets it be", "[device]") {
  SimulatedDevice device(freeDevice(), HandModel::light(),
                         {HandMotion::Kind::Press, -Vec3::UnitZ(), Vec3::UnitX(), 0, 0, 4, 1});
  run(device, 2000, Vec3(0, 0, 0.6));
  const HandModel hand = HandModel::light();
  CHECK(device.handle().z() == Approx(0.6 / hand.arm_stiffness + 0.6 / hand.grip_stiffness).epsilon(0.01));
}

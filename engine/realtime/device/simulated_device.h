#pragma once

#include <algorithm>
#include <array>

#include "realtime/device/device_backend.h"
#include "realtime/device/hand_model.h"

namespace palpate {

/// A haptic device as a mass on bearings, with its motors, its encoders and the way to the computer; it turns, too. The
/// numbers are of the order of data sheets of desktop devices; no real one was measured.
struct SimulatedDeviceSettings {
  double mass = 0.05;          // kg, as felt at the handle
  double damping = 0.1;        // N s/m
  double friction = 0.15;      // N, Coulomb
  double encoder_step = 5e-5;  // m
  double max_force = 3.3;      // N, of the vector
  double rate_hz = 1000;       // of poses
  double delay_s = 0;          // there and back at most: each way takes a random part of its half
  std::uint64_t seed = 1;
  double least_delay_s = 0;  // of that: each way takes its half at least
  bool tells_felt = true;    // which force the motors have
  bool turns_hand = true;    // it has motors for torques, too
  double lever = 0.02;       // m, at which its mass, damping and largest force are those in turning, the hand's, too

  /// As DeviceSettings::classes: light, medium, strong.
  static SimulatedDeviceSettings of(int device_class);
};

/// Simulates a device and the hand that holds it up to the time that it is asked for, in steps of 50 us: the same calls
/// give the same bits.
/// Real-time: no allocation, no lock, no throw; 20 steps a millisecond.
class SimulatedDevice final : public DeviceBackend {
 public:
  SimulatedDevice(const SimulatedDeviceSettings& device, const HandModel& hand, const HandMotion& motion)
      : device_(device), hand_(hand), motion_(motion), random_(device.seed) {}

  std::string name() const override { return "simulated device and hand"; }
  bool read(std::int64_t now_ns, DevicePose& pose) override;
  void write(std::int64_t now_ns, const DeviceWrench& wrench) override;

  /// Sends no poses while it is; hand and device go on. For tests.
  void setSilent(bool silent) { silent_ = silent; }

  const Vec3& handle() const { return x_; }           // m
  const Vec3& force() const { return force_.force; }  // N, that the motors give
  const Vec3& turn() const { return turn_; }          // rad, of the handle, a rotation vector
  /// J, that the motors have given to the handle.
  double work() const { return work_; }

 private:
  static constexpr std::size_t kUnderway = 64;  // messages, each way
  static constexpr double step_s = 50e-6;
  void step();
  void sendPose();
  /// ns, that a message takes.
  std::int64_t way() {
    const double least = std::min(device_.least_delay_s, device_.delay_s);
    return static_cast<std::int64_t>(0.5e9 * (least + (device_.delay_s - least) * random_.next()));
  }

  struct PoseUnderway {
    std::int64_t arrives = -1;  // ns; -1: none
    DevicePose pose;
  };
  struct WrenchUnderway {
    std::int64_t arrives = -1;
    DeviceWrench wrench;
  };
  const SimulatedDeviceSettings device_;
  const HandModel hand_;
  const HandMotion motion_;
  SteadyRandom random_;
  bool silent_ = false, begun_ = false;
  std::int64_t begin_ns_ = 0;
  std::int64_t steps_ = 0;
  Vec3 x_ = Vec3::Zero(), v_ = Vec3::Zero();  // handle
  Vec3 turn_ = Vec3::Zero(), turning_ = Vec3::Zero();
  Vec3 arm_x_ = Vec3::Zero(), arm_v_ = Vec3::Zero();  // arm
  DeviceWrench force_;
  double work_ = 0;
  std::uint32_t sent_ = 0, read_ = 0;
  std::array<PoseUnderway, kUnderway> poses_{};
  std::array<WrenchUnderway, kUnderway> wrenches_{};
};

}  // namespace palpate

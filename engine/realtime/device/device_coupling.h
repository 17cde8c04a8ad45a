#pragma once

#include <cstdint>

#include "realtime/channels/snapshot.h"
#include "realtime/device/device_signals.h"
#include "realtime/device/device_target.h"
#include "simulation/device_settings.h"
#include "simulation/model.h"

namespace palpate {

/// What a coupling has seen so far.
struct DeviceReport {
  std::int64_t poses = 0;                    // that came
  std::int64_t silences = 0;                 // times that they stopped coming
  std::int64_t fades = 0;                    // times that the tissue was put back, frozen or late
  double energy_J = 0, lowest_energy_J = 0;  // observed: what the hand has put in and not got back
  double damped_J = 0;                       // taken out again by the passivity controller
  double peak_force = 0;                     // N
  double delay_s = 0;                        // there and back, as far as the device tells
  double stiffness = 0;                      // N/m, in force
  bool engaged = false;
};

/// The spring and damper between a haptic device and the loop's tool: what the hand feels. A plain function of what it
/// is given, call by call: no clock, no thread.
///
///   F = Kc (x_tool - x_dev) + Bc (v_tool - v_dev), in contact (it comes and goes in 5 ms), else 0
///   |F| <= max_force, |dF/dt| <= max_force / rise_time
///   Kc (T/2 + delay) <= own_damping       or the delay would make more energy than device and hand can take
///
/// Passivity observer and controller (Hannaford and Ryu 2002): E += F . dx, what the hand puts in; where E < 0, damping
/// alpha = -E / (v^2 T) is added, as far as a discrete damper is stable itself. In air what was dissipated is
/// forgotten.
///
/// Dead man: no pose for 10 ms, and the force goes to zero within 40 ms; likewise where the tissue was put back, is
/// frozen or late. Then the coupling starts from rest: the device pulls from where the tool is, and that difference
/// vanishes within 0.3 s.
///
/// World and device have the same axes. The handle's pose when it takes the tool is the tool's start.
/// Real-time: no allocation, no lock, no throw. Test: realtime/device/device_coupling_test.cpp
class DeviceCoupling {
 public:
  static constexpr double silent_seconds = 0.010;
  static constexpr double fade_seconds = 0.040;
  static constexpr double slack_seconds = 0.3;

  DeviceCoupling(const DeviceSettings& settings, const Model& model);

  /// One call of the device's thread.
  /// @param now   ns
  /// @param pose  what the device has sent since the last call; null: nothing
  /// @param tool  the loop's newest tick; ForceSample::wall_ns by the same clock
  /// @param put_backs  how often the tissue was put back so far
  DeviceWrench update(std::int64_t now, const DevicePose* pose, const ForceSample& tool, std::uint32_t put_backs = 0);

  /// Where the tool is pulled, after update().
  const DeviceTarget& target() const { return target_; }
  DeviceReport report() const;

 private:
  enum class Phase { Off, Engaged, Fading };
  void take(std::int64_t now, const DevicePose& pose);
  void watchDelay(std::int64_t now, std::uint32_t felt);
  bool followTool(std::int64_t now, const ForceSample& tool, std::uint32_t put_backs);
  void engage(std::int64_t now);
  Vec3 coupling(std::int64_t now, double seconds);
  Vec3 limited(const Vec3& wanted, double seconds) const;
  Vec3 passive(const Vec3& force, double seconds);
  Vec3 toWorld(const Vec3& device) const { return start_.position + settings_.scale * (device - first_.position); }

  static constexpr std::size_t kRemembered = 256;  // wrenches whose time of sending is known

  const DeviceSettings settings_;
  const Pose start_;
  const double rate_hz_, jump_;  // m, more than the tool goes in a tick
  Phase phase_ = Phase::Off;
  DeviceTarget target_;
  bool anchored_ = false;
  Pose first_;                    // of the handle, when it took the tool
  DevicePose handle_;             // the newest
  Vec3 velocity_ = Vec3::Zero();  // m/s, of the handle, smoothed
  std::int64_t pose_ns_ = 0, now_ = 0;
  double interval_s_ = 1e-3;  // from pose to pose
  double delay_s_ = 0;
  double stiffness_;  // N/m, in force, on the handle
  std::int64_t tool_tick_ = -1, losses_ = 0;
  std::int64_t tool_ns_ = 0;  // when its tick came
  std::uint32_t put_backs_ = 0;
  Pose tool_;                          // world
  Vec3 tool_velocity_ = Vec3::Zero();  // m/s, world
  bool touching_ = false;
  double contact_ = 0;         // share of the coupling in force
  Vec3 slack_ = Vec3::Zero();  // m, world
  std::int64_t phase_ns_ = 0;
  Vec3 held_ = Vec3::Zero(), force_ = Vec3::Zero();  // N
  std::uint32_t sequence_ = 0;
  std::int64_t sent_ns_[kRemembered] = {};
  DeviceReport report_;
};

}  // namespace palpate

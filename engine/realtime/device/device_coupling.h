#pragma once

#include <cstdint>

#include "model/model.h"
#include "realtime/channels/force_output.h"
#include "realtime/channels/snapshot.h"
#include "realtime/device/device_signals.h"
#include "realtime/device/device_target.h"
#include "realtime/device/port_energy.h"
#include "scene/device_settings.h"

namespace palpate {

/// What a coupling has seen so far.
struct DeviceReport {
  std::int64_t poses = 0;                    // that came
  std::int64_t silences = 0;                 // times that they stopped coming
  std::int64_t fades = 0;                    // times that the tissue was put back, frozen or late
  double energy_J = 0, lowest_energy_J = 0;  // at the handle: what the hand has put in and not got back, at the worst
  double damped_J = 0;                       // taken out again, as the spring's end slipped
  double peak_force = 0;                     // N
  double peak_torque = 0;                    // N m
  double delay_s = 0;                        // there and back, as far as the device tells; else what is assumed
  double stiffness = 0;                      // N/m, in force
  double slipped_m = 0;                      // that the spring's end is from the handle's place now
  double lacking = 0;    // share of the force that the hand should feel, which the slip takes from it now
  double lacking_s = 0;  // for how long that was above felt_lacking
  bool engaged = false;
};

/// The spring and damper between a haptic device and the loop's tool: what the hand feels. A plain function of what it
/// is given, call by call: no clock, no thread.
///
///   F = Kc (x_tool - x_dev) + Bc (v_tool - v_dev), in contact (it comes and goes in 5 ms), else 0
///   |F| <= max_force, |dF/dt| <= max_force / rise_time where it rises
///   Kc (T/2 + delay)   <= own_damping        or the delay would make more energy than device and hand can take
///   Kc (T/2 + delay)^2 <= lightest_handle    or a light handle would be where it isn't expected before the force comes
///
/// and the same in turning, with ways and torques measured at DeviceSettings::lever. x_dev is where the handle will be
/// when the force reaches it, as far as its velocity tells.
///
/// Passivity: the energy at the handle is counted with the delay in it (PortEnergy), E = what the hand has put in and
/// not got back. A spring may push no harder than one that has E left:
///
///   |F| <= sqrt(2 K (E + free_energy_J)) + b v_in     1/K = 1/Kc + h^2 / lightest_handle, h: until F has acted
///
/// and |F| v h <= 0.3 mJ, with v nearly the highest speed of late.
/// Where that is less than Kc asks for, the spring's end slips towards the tool, as in a clutch: the tool comes out of
/// the tissue, and what was stored is lost. So no bounce grows, whatever hand, handle and delay there are. The slip is
/// taken back in air, and in contact where that charges no spring. A contact only pushes: no force pulls the handle
/// against the contact's normal.
///
/// Dead man: no pose for 10 ms, or for two and a half periods of a device that is slower (down to 50 Hz), and the force
/// goes to zero within 40 ms; likewise where the tissue was put back, is frozen or late. Then the handle takes the tool
/// again where both are, with the force that is out, and no more energy than that holds.
///
/// What the hand has got without paying, in a gap or by noise, is held against it until a second without force in
/// air: no bounce lasts over that.
///
/// World and device have the same axes. The handle's pose when it takes the tool is the tool's start.
/// Real-time: no allocation, no lock, no throw. Test: realtime/device/device_coupling_test.cpp
class DeviceCoupling {
 public:
  static constexpr double silent_seconds = 0.010;  // of a device that is quick enough
  static constexpr double slowest_period = 0.020;  // s; slower, and a hand would be told of its fall after 0.1 s
  static constexpr double calm_seconds = 1.0;      // without force in air: what was given is forgotten (README.md)
  static constexpr double fade_seconds = 0.040;
  static constexpr double felt_lacking = 0.2;      // a share of its force, that a hand notices
  static constexpr double slack_seconds = 0.1;     // in which a slip goes, to 1/e
  static constexpr double lightest_handle = 0.02;  // kg
  static constexpr double free_energy_J = 1e-4;    // that the hand may get without having paid: contacts begin sooner

  DeviceCoupling(const DeviceSettings& settings, const Model& model);

  /// One call of the device's thread.
  /// @param told  ns, by a clock that goes on; a step back counts as no time
  /// @param pose  what the device has sent since the last call; null: nothing
  /// @param tool  the loop's newest tick; ForceSample::wall_ns by the same clock
  /// @param put_backs  how often the tissue was put back so far
  DeviceWrench update(std::int64_t told, const DevicePose* pose, const ForceSample& tool, std::uint32_t put_backs = 0);

  /// Where the tool is pulled, after update().
  const DeviceTarget& target() const { return target_; }
  DeviceReport report() const;
  /// Of report(), at any time: cheap.
  double lacking() const;
  std::int64_t poses() const { return report_.poses; }

 private:
  enum class Phase { Off, Engaged, Fading };
  void take(std::int64_t now, const DevicePose& pose);
  void stayWhile(const DevicePose& pose);
  double unknown() const;
  double silence() const;
  bool followTool(std::int64_t now, const ForceReading& reading, std::uint32_t put_backs);
  void engage();
  void soften(double seconds);
  void placeTarget();
  AlongAndTurning spring(std::int64_t now) const;
  void slip(const AlongAndTurning& way);
  void giveSlackBack(const AlongAndTurning& stretch, double seconds);
  AlongAndTurning coupling(std::int64_t now, double seconds);
  void pay(std::int64_t now, AlongAndTurning& force);
  AlongAndTurning limited(const AlongAndTurning& wanted, double seconds) const;
  Vec3 toWorld(const Vec3& device) const { return start_.position + settings_.scale * (device - first_.position); }

  const DeviceSettings settings_;
  const Pose start_;
  const double rate_hz_, jump_;  // m, more than the tool goes in a tick
  Phase phase_ = Phase::Off;
  DeviceTarget target_;
  PortEnergy energy_;
  bool anchored_ = false;
  Pose first_;                                  // of the handle, when it took the tool
  DevicePose handle_;                           // the newest
  AlongAndTurning velocity_, newest_velocity_;  // m/s, of the handle: smoothed, and since the last pose
  double speed_ = 0;                            // m/s, nearly the highest of late
  std::int64_t told_ = 0, now_ = 1;             // ns, the caller's clock, and what has gone by
  std::int64_t pose_ns_ = 0;
  double interval_s_ = 1e-3, last_interval_ = 0;  // from pose to pose
  double calm_s_ = 0;                             // without force, in air
  double stiffness_;                              // N/m, in force, on the handle
  std::int64_t tool_tick_ = -1, losses_ = 0;
  std::int64_t tool_ns_ = 0;  // when its tick came
  std::uint32_t put_backs_ = 0;
  Pose tool_;                      // world
  AlongAndTurning tool_velocity_;  // m/s, world
  Vec3 normal_ = Vec3::Zero();     // of the contact; 0: not known
  bool touching_ = false;
  double contact_ = 0;              // share of the coupling in force
  Vec3 slack_ = Vec3::Zero();       // m, world: how far the spring's end has slipped,
  Quat turned_ = Quat::Identity();  // and how far it is turned
  std::int64_t phase_ns_ = 0;
  bool lost_ = false;             // fading as the tissue was put back: to the end
  AlongAndTurning held_, force_;  // N
  std::uint32_t sequence_ = 0;
  DeviceReport report_;
};

}  // namespace palpate

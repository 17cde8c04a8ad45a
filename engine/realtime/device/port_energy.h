#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "base/types.h"

namespace palpate {

/// What acts at a device's handle, or how the handle moves: along (N, m, m/s), and in turning, measured at a lever
/// (torque over lever, turn times lever), so that both have the same units and turning is a way like any other.
struct AlongAndTurning {
  Vec3 along = Vec3::Zero(), turning = Vec3::Zero();

  double dot(const AlongAndTurning& other) const { return along.dot(other.along) + turning.dot(other.turning); }
};

/// The energy that has passed through a device's handle, counted there: each way of the handle with the force that the
/// motors had on it, not with the newest one, which is still under way. Which force that was the device tells
/// (DevicePose::felt). Where it does not, all delays up to `longest_assumed_s` are reckoned with side by side, and the
/// one by which the hand has paid the least is believed.
///
///   reserve += -F . dx     with that F of those which the motors had between two poses that is the worst for us
///
/// both smoothed alike, or the steps of an encoder would be counted as energy.
/// What this is too pessimistic by is given back slowly. Energy that went in through turning counts for torques only:
/// a device that can't turn the hand is not paid by it.
/// Real-time: no allocation, no lock, no throw. Test: realtime/device/port_energy_test.cpp
class PortEnergy {
 public:
  static constexpr double longest_assumed_s = 0.048;
  static constexpr double assumed_s = 0.010;  // until a longer one shows

  /// A force went out.
  void sent(std::uint32_t sequence, std::int64_t now, const AlongAndTurning& force);

  /// The handle has moved since the pose before.
  /// @param felt      newest force that it had; 0: not told
  /// @param interval  s, since the pose before
  /// @param gap       poses were missing: what the motors did meanwhile is not known
  void moved(std::int64_t now, std::uint32_t felt, const AlongAndTurning& way, double interval, bool gap);

  /// In air nothing is stored: what was dissipated is forgotten, what was given is not,
  void forget();
  /// but where no force has been for so long that any bounce has ended.
  void beginAnew();
  /// The spring holds no more than this, J.
  void holdAtMost(double energy);
  /// Time has passed, s.
  void forgive(double seconds);

  /// J, that the hand has put in and not got back: through forces alone, and through torques, too.
  double pushed() const;
  double all() const;

  /// J, that the forces under way will give to a handle that goes on with this velocity.
  /// @param push_alone  without torques
  double underway(std::int64_t now, const AlongAndTurning& velocity, bool push_alone) const;

  /// s, there and back, without the device's own period: told and nearly the longest of late (but for one of 64 poses:
  /// a program that stood still for a moment has no slow line), or assumed.
  double delay() const { return delay_s_; }
  bool told() const { return told_; }

 private:
  static constexpr std::size_t kRemembered = 256;
  static constexpr std::size_t kAssumed = 13;  // 0 .. longest_assumed_s
  struct Sent {
    std::int64_t ns = 0;
    AlongAndTurning force, smooth;
  };
  /// By one delay: at the worst, and by the mean of the forces between two poses.
  struct Account {
    double worst = 0, mean = 0;
    void add(double least, double average) { worst += least, mean += average; }
  };
  const Sent& at(std::uint32_t sequence) const { return sent_[sequence % kRemembered]; }
  std::uint32_t newestBefore(std::int64_t ns, std::uint32_t from) const;
  void add(std::size_t k, std::uint32_t from, std::uint32_t to, const AlongAndTurning& way, bool gap);

  std::array<Sent, kRemembered> sent_{};
  std::uint32_t newest_ = 0, felt_ = 0;
  std::array<std::uint32_t, kAssumed> assumed_felt_{};
  std::array<Account, kAssumed> pushed_{}, all_{};
  AlongAndTurning behind_;  // m, of the handle: how far the smoothed way is
  /// The two longest of some delays, s.
  struct Longest {
    double first = 0, second = 0;
    void add(double delay) {
      second = std::max(second, std::min(first, delay));
      first = std::max(first, delay);
    }
  };
  double sustained(double delay);

  double delay_s_ = 0, interval_s_ = 1e-3;
  Longest delays_, delays_before_;  // of the last poses, and of the 64 before them
  int delay_count_ = 0;
  std::uint32_t after_gap_ = 0;  // newest force when poses came again: older ones tell no delay
  bool told_ = false;
};

}  // namespace palpate

#pragma once

#include <array>
#include <cstdint>

#include "base/types.h"

namespace palpate {

/// Where a viewer wants the tool, tick by tick: it asks a few times a second, unevenly, and each tick goes an even
/// share of the way. Two kinds of wishes add up: ways to poses, each in a time, and a steady motion while keys are
/// held.
///
///   way:     x += (target - x) / ticks left, likewise the turn
///   steady:  x += v / rate, R <- exp(w / rate) R, until it is asked anew or its time is over
///
/// So a key's speed is the tool's speed whether two or sixty pictures are drawn in a second, and a viewer that hangs
/// leaves no tool running away.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/tool_goal_test.cpp
class ToolGoal {
 public:
  static constexpr std::size_t max_ways = 6;
  static constexpr double longest_seconds = 10;  // of a way or a steady motion

  ToolGoal(const Pose& start, double rate_hz) : rate_hz_(rate_hz), pose_(start) {}

  const Pose& pose() const { return pose_; }

  /// At once, and nothing is under way any more.
  void jumpTo(const Pose& pose);

  /// Forgets the ways that are left. @param seconds  for the way; 0: with the next tick
  void moveTo(const Pose& pose, double seconds);
  /// After those that are left; the last where there are too many.
  void thenMoveTo(const Pose& pose, double seconds);

  /// @param velocity  m/s; @param turn  rad/s about the tip; @param seconds  that it lasts
  void steer(const Vec3& velocity, const Vec3& turn, double seconds);

  /// One tick.
  void advance();

 private:
  struct Way {
    Pose to;
    std::int64_t ticks = 1;  // left
  };
  std::int64_t ticksIn(double seconds) const;

  const double rate_hz_;
  Pose pose_;
  std::array<Way, max_ways> ways_;  // the first `way_count_`, the present one first
  std::size_t way_count_ = 0;
  Vec3 velocity_ = Vec3::Zero();  // m/s
  Vec3 turn_ = Vec3::Zero();      // rad/s
  std::int64_t steer_ticks_ = 0;  // left
};

}  // namespace palpate

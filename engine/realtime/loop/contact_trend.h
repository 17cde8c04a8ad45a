#pragma once

#include "base/types.h"
#include "model/report.h"

namespace palpate {

/// What follows from the tool's way and force over several ticks; watches only, nothing depends on it.
///
///   work      = sum over steps of the mean of the forces on the tissue before and after times the tool's way (a hand
///               may swing within a tick), and over ticks of the torques about the tip times its turn
///   stiffness = covariance of force and travel along the contact's normal over the variance of the travel, newer ticks
///               counting more (exponential forgetting in memory_seconds)
///
/// A tool that stands still leaves the stiffness as it was; one that leaves the tissue makes it 0, not known.
/// Real-time: no allocation, no lock, no throw. Test: realtime/loop/contact_trend_test.cpp
struct ContactTrend {
  static constexpr double memory_seconds = 0.05;
  static constexpr double least_way = 1e-6;  // m, standard deviation of the travel: less tells nothing of a stiffness

  double work = 0;       // J, that the tool has done on the tissue
  double stiffness = 0;  // N/m; 0: not known

  /// A tick is done: the tool is at `pose`, and this is the tick's report.
  void update(const Pose& pose, const StepReport& report, double rate_hz);

  /// The tissue was put back: the way from there counts.
  /// @param all  the work, too, begins anew
  void restart(bool all);

  /// A contact begins, with this force along its normal, or ends. @param force_along  N
  void forget(double force_along);

  // Of the tick before.
  bool known = false;
  Pose pose;
  Vec3 torque = Vec3::Zero();  // N m, on the tool
  bool touched = false;
  double travel = 0, mean_travel = 0, mean_force = 0;  // m, m, N, along the normal since first touch
  double variance = 0, covariance = 0;                 // m^2, N m
};

}  // namespace palpate

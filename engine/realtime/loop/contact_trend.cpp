#include "realtime/loop/contact_trend.h"

#include <cmath>

namespace palpate {

void ContactTrend::update(const Pose& now, const StepReport& report, double rate_hz) {
  const Vec3& f = report.tool_force;
  const Vec3& n = report.contact_normal;
  const bool touches = !n.isZero(0);
  if (known) {
    const Vec3 way = now.position - pose.position;
    Quat turn = now.orientation * pose.orientation.conjugate();
    if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
    const Vec3 angle = 2 * turn.vec();  // of a small turn
    work += report.loads[0].work - 0.5 * (torque + report.tool_torque).dot(angle);
    if (touches && touched) {
      const double g = std::exp(-1 / (memory_seconds * rate_hz));
      travel -= way.dot(n);
      const double ds = travel - mean_travel, df = f.dot(n) - mean_force;
      mean_travel += (1 - g) * ds;
      mean_force += (1 - g) * df;
      variance = g * (variance + (1 - g) * ds * ds);
      covariance = g * (covariance + (1 - g) * ds * df);
      if (variance > least_way * least_way) stiffness = covariance / variance;
    }
  }
  if (!touches || !touched) forget(f.dot(n));
  known = true;
  touched = touches;
  pose = now;
  torque = report.tool_torque;
}

void ContactTrend::restart(bool all) {
  if (all) work = 0;
  known = touched = false;
  forget(0);
}

void ContactTrend::forget(double force_along) {
  travel = mean_travel = variance = covariance = stiffness = 0;
  mean_force = force_along;
}

}  // namespace palpate

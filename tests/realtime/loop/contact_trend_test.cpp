#include "realtime/loop/contact_trend.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

using namespace palpate;

namespace {

constexpr double rate_hz = 500;

/// A spring along `normal` that pushes from where the tool is at `depth` 0, in a tick from one depth to another.
StepReport spring(double stiffness, double from, double depth, const Vec3& normal) {
  StepReport report;
  from = std::max(from, 0.0);
  report.loads[0].work = 0.5 * stiffness * (std::pow(std::max(depth, 0.0), 2) - from * from);
  if (depth <= 0) return report;
  report.tool_force = stiffness * depth * normal;
  report.contact_normal = normal;
  return report;
}

Pose at(const Vec3& position) {
  Pose pose;
  pose.position = position;
  return pose;
}

}  // namespace

TEST_CASE("Pressed into a spring, stiffness and work are the spring's", "[contact_trend]") {
  const Vec3 normal = Vec3(1, 2, 2) / 3;
  constexpr double k = 90, step = 2e-5;  // N/m, m
  ContactTrend trend;
  for (int n = -10; n <= 100; ++n)
    trend.update(at(-n * step * normal), spring(k, (n - 1) * step, n * step, normal), rate_hz);
  CHECK(trend.stiffness == Approx(k));
  CHECK(trend.work == Approx(0.5 * k * 100 * step * 100 * step));

  // At rest both stay; across the normal there is no work; on the way out it comes back, and the stiffness goes.
  const Vec3 across = Vec3(2, -1, 0);
  const StepReport held = spring(k, 100 * step, 100 * step, normal);
  for (int n = 0; n < 50; ++n) trend.update(at(-100 * step * normal), held, rate_hz);
  for (int n = 1; n < 50; ++n) trend.update(at(-100 * step * normal + n * step * across), held, rate_hz);
  CHECK(trend.stiffness == Approx(k));
  CHECK(trend.work == Approx(0.5 * k * 100 * step * 100 * step));
  for (int n = 99; n >= -5; --n)
    trend.update(at(-n * step * normal + 49 * step * across), spring(k, (n + 1) * step, n * step, normal), rate_hz);
  CHECK(trend.work == Approx(0).margin(1e-12));
  CHECK(trend.stiffness == 0);
}

TEST_CASE("A turn against a torque is work", "[contact_trend]") {
  ContactTrend trend;
  constexpr double torque = 0.01, turn = 1e-3;  // N m, rad a tick
  for (int n = 0; n <= 200; ++n) {
    StepReport report;
    report.tool_torque = Vec3(0, 0, -torque);
    Pose pose;
    pose.orientation = Eigen::AngleAxisd(n * turn, Vec3::UnitZ());
    if (n % 2 == 1) pose.orientation.coeffs() = -pose.orientation.coeffs();  // the same turn
    trend.update(pose, report, rate_hz);
  }
  CHECK(trend.work == Approx(torque * 200 * turn).epsilon(1e-6));  // 2 sin(a/2) for a
  trend.restart(true);
  CHECK(trend.work == 0);
}

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <random>

#include "contact/tool.h"

using namespace palpate;

namespace {

const ToolShape kSphere{ToolKind::Sphere, 0.01, 0.06, 0.0};
const ToolShape kFlat{ToolKind::FlatCylinder, 0.01, 0.06, 0.002};
const ToolShape kCapsule{ToolKind::Capsule, 0.01, 0.06, 0.0};

Vec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> side(-0.02, 0.02), axis(-0.02, 0.08);
  return {side(random), side(random), axis(random)};
}

Vec3 finiteDifference(const ToolShape& tool, const Vec3& x, double h) {
  Vec3 gradient;
  for (int c = 0; c < 3; ++c) {
    const Vec3 step = h * Vec3::Unit(c);
    gradient[c] = (toolDistance(tool, x + step).distance - toolDistance(tool, x - step).distance) / (2.0 * h);
  }
  return gradient;
}

}  // namespace

TEST_CASE("Tool distances have their closed forms", "[tool]") {
  struct Case {
    ToolShape tool;
    Vec3 x;
    double distance;
    Vec3 normal;
  };
  const double s = std::sqrt(0.5);
  const Case cases[] = {
      {kSphere, {0, 0, 0}, 0.0, {0, 0, -1}},
      {kSphere, {0, 0, -0.004}, 0.004, {0, 0, -1}},
      {kSphere, {0.013, 0, 0.01}, 0.003, {1, 0, 0}},
      {kSphere, {0, 0, 0.01}, -0.01, {0, 0, -1}},  // the centre: out is forwards
      {kFlat, {0.003, 0.004, 0}, 0.0, {0, 0, -1}},
      {kFlat, {0, 0.007, -0.005}, 0.005, {0, 0, -1}},
      {kFlat, {0, -0.012, 0.03}, 0.002, {0, -1, 0}},
      {kFlat, {0, 0, 0.003}, -0.003, {0, 0, -1}},
      {kFlat, {0.009, 0, 0.03}, -0.001, {1, 0, 0}},
      {kFlat, {0, 0, 0.061}, 0.001, {0, 0, 1}},
      // On the rim's diagonal, 3 mm from the circle of its centres.
      {kFlat, {0.008 + 0.003 * s, 0, 0.002 - 0.003 * s}, 0.001, {s, 0, -s}},
      {kCapsule, {0, 0, -0.001}, 0.001, {0, 0, -1}},
      {kCapsule, {0.012, 0, 0.04}, 0.002, {1, 0, 0}},
      {kCapsule, {0, 0, 0.065}, 0.005, {0, 0, 1}},
      {kCapsule, {0, 0.004, 0.03}, -0.006, {0, 1, 0}},
  };
  for (const Case& c : cases) {
    CAPTURE(static_cast<int>(c.tool.kind), c.x.transpose());
    const ToolDistance d = toolDistance(c.tool, c.x);
    CHECK(d.distance == Approx(c.distance).margin(1e-15));
    CHECK((d.normal - c.normal).norm() < 1e-12);
  }
}

TEST_CASE("Tool normals are the distance's gradient, and both are exact", "[tool]") {
  std::mt19937 random(7);
  for (const ToolShape& tool : {kSphere, kFlat, kCapsule}) {
    CAPTURE(static_cast<int>(tool.kind));
    double worst_gradient = 0.0, worst_foot = 0.0;
    int points = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random), y = randomPoint(random);
      const ToolDistance d = toolDistance(tool, x);
      // A distance changes by no more than the way between two points.
      REQUIRE(std::abs(d.distance - toolDistance(tool, y).distance) <= (x - y).norm() + 1e-15);
      REQUIRE(d.normal.norm() == Approx(1.0).epsilon(1e-12));
      if (d.distance < -0.9 * smoothDepth(tool)) continue;
      ++points;
      // The foot of x stands on the surface with the same normal.
      const ToolDistance foot = toolDistance(tool, x - d.distance * d.normal);
      worst_foot = std::max({worst_foot, std::abs(foot.distance) / tool.radius, (foot.normal - d.normal).norm()});
      // Central differences: the third derivative is at most ~ 1 / (0.1 e)^2, e = 2 mm; seams are C1,
      // where the error is h times the jump of curvature, at most 1 / (0.1 e).
      worst_gradient = std::max(worst_gradient, (finiteDifference(tool, x, 1e-8) - d.normal).norm());
    }
    CHECK(points > 10000);
    CHECK(worst_foot < 1e-12);
    CHECK(worst_gradient < 1e-4);
  }
}

TEST_CASE("Tool normals turn continuously down to the smooth depth", "[tool]") {
  std::mt19937 random(11);
  for (const ToolShape& tool : {kSphere, kFlat, kCapsule}) {
    const double h = 1e-6;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random);
      const ToolDistance d = toolDistance(tool, x);
      if (d.distance < -0.8 * smoothDepth(tool)) continue;
      // The smallest radius of curvature there is 0.2 smoothDepth.
      const Vec3 turn = toolDistance(tool, x + h * randomPoint(random).normalized()).normal - d.normal;
      REQUIRE(turn.norm() <= 1.1 * h / (0.2 * smoothDepth(tool)));
    }
  }
}

TEST_CASE("The way out of a tool along a direction", "[tool]") {
  CHECK(exitDistance(kFlat, {0.003, 0, 0.004}, -Vec3::UnitZ()) == Approx(0.004).epsilon(1e-3));
  CHECK(exitDistance(kFlat, {0.003, 0, 0.03}, Vec3::UnitX()) == Approx(0.007).epsilon(1e-3));
  // A chord of the sphere: height c over the centre plane, half chord sqrt(R^2 - c^2).
  CHECK(exitDistance(kSphere, {0, 0.006, 0.01}, Vec3::UnitX()) == Approx(0.008).epsilon(1e-3));
  CHECK(exitDistance(kCapsule, {0, 0, 0.03}, -Vec3::UnitZ()) == Approx(0.03).epsilon(1e-3));
  CHECK(exitDistance(kSphere, {0, 0, -0.001}, -Vec3::UnitZ()) == 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(exitDistance(kSphere, {nan, 0, 0}, -Vec3::UnitZ()) == 0.0);
}

TEST_CASE("The tip's profile lies on the surface", "[tool]") {
  for (const ToolShape& tool : {kSphere, kFlat, kCapsule}) {
    for (double r = 0.0; r <= tool.radius; r += 0.05 * tool.radius) {
      CHECK(std::abs(toolDistance(tool, {0.6 * r, 0.8 * r, tipProfile(tool, r)}).distance) < 1e-15);
    }
    CHECK(std::isinf(tipProfile(tool, 1.01 * tool.radius)));
  }
}

TEST_CASE("The rim is no rounder than the cylinder allows", "[tool]") {
  CHECK(edgeRadius({ToolKind::FlatCylinder, 0.01, 0.06, 0.0}) == Approx(0.003));
  CHECK(edgeRadius({ToolKind::FlatCylinder, 0.01, 0.06, 0.02}) == Approx(0.01));
  CHECK(edgeRadius({ToolKind::FlatCylinder, 0.01, 0.006, 0.02}) == Approx(0.003));
}

TEST_CASE("No point of a tool travels further than the bound", "[tool]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Pose from, to;
    from.orientation = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    to.orientation = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    to.position = 0.01 * Vec3(normal(random), normal(random), normal(random));
    const double bound = largestTravel(kFlat, from, to);
    for (const Vec3& x : {Vec3(0, 0, 0), Vec3(0.01, 0, 0.06), Vec3(0, -0.01, 0.06), Vec3(-0.01, 0, 0)}) {
      REQUIRE((to.toWorld(x) - from.toWorld(x)).norm() <= bound * (1.0 + 1e-12));
    }
  }
}

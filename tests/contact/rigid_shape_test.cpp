#include "contact/rigid_shape.h"

#include <catch2/catch.hpp>
#include <random>

#include "contact/rigid_bodies.h"
#include "discretization/surface/solids.h"

using namespace palpate;

namespace {

using Kind = RigidShape::Kind;

RigidShape solid(Kind kind) {
  RigidShape shape;
  shape.kind = kind;
  shape.point = Vec3(0.01, -0.02, 0.03);
  shape.normal = Vec3(1, 2, -1).normalized();
  shape.half = Vec3(0.02, 0.03, 0.01);
  shape.radius = 0.02;
  shape.height = 0.05;
  return shape;
}

Vec3 drawn(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-0.08, 0.08);
  const double x = any(random), y = any(random);
  return {x, y, any(random)};
}

}  // namespace

TEST_CASE("Gaps of rigid solids are distances: known ones, with the gradient that is told", "[contact][rigid]") {
  Vec3 n;
  const Vec3 p(0.01, -0.02, 0.03);
  CHECK(solid(Kind::HalfSpace).gapAt(p + 0.004 * Vec3(1, 2, -1).normalized(), n) == Approx(0.004));
  CHECK(solid(Kind::Box).gapAt(p + Vec3(0.023, 0.034, 0), n) == Approx(0.005));
  CHECK(solid(Kind::Box).gapAt(p + Vec3(0, 0.028, 0), n) == Approx(-0.002));
  CHECK(solid(Kind::Sphere).gapAt(p + Vec3(0, 0, -0.018), n) == Approx(-0.002));
  RigidShape can = solid(Kind::Cylinder);
  can.normal = Vec3::UnitX();
  CHECK(can.gapAt(p + Vec3(0.02, 0.025, 0), n) == Approx(0.005));
  CHECK(can.gapAt(p + Vec3(0.053, 0, 0.024), n) == Approx(0.005));
  CHECK(can.gapAt(p + Vec3(0.049, 0.001, 0), n) == Approx(-0.001));
  CHECK(can.gapAt(p + Vec3(-0.003, 0, 0), n) == Approx(0.003));

  std::mt19937 random(7);
  for (const Kind kind : {Kind::HalfSpace, Kind::Box, Kind::Sphere, Kind::Cylinder}) {
    const RigidShape shape = solid(kind);
    for (int k = 0; k < 300; ++k) {
      const Vec3 x = drawn(random), y = drawn(random);
      Vec3 normal, unused;
      const double gap = shape.gapAt(x, normal);
      CHECK(std::abs(gap - shape.gapAt(y, unused)) <= (x - y).norm() + 1e-12);
      constexpr double h = 1e-7;
      // Along the normal the gap grows as the way does, outside everywhere, inside but across an edge's diagonal.
      if (gap > 1e-6) CHECK(shape.gapAt(x + h * normal.normalized(), unused) == Approx(gap + h).margin(1e-11));
    }
  }
}

TEST_CASE("A surface has two sides, each with its clearance", "[contact][rigid]") {
  const SurfaceTree ball(ellipsoidSurface(Vec3::Constant(0.03), 0.003));
  for (const bool inside : {true, false}) {
    SurfaceSide side;
    side.inside = inside;
    side.clearance = 0.001;
    const RigidShape shape = surfaceShape(ball, side, 0.006);
    for (const double r : {0.028, 0.0295, 0.0305, 0.032}) {
      Vec3 normal;
      const Vec3 x = r * Vec3(2, -1, 2).normalized();
      const double gap = inside ? 0.031 - r : r - 0.031;
      CHECK(shape.gapAt(x, normal) == Approx(gap).margin(2e-4));
      CHECK(normal.normalized().dot(x / r) == Approx(inside ? -1 : 1).margin(0.02));
      CHECK(shape.leastGap(x) == 0);
    }
    CHECK(shape.leastGap(Vec3(0.06, 0, 0)) > 0.015);
  }
}

TEST_CASE("A small ball's surface is as far as the ball, however far apart the nodes are", "[contact][rigid]") {
  const RigidShape shape =
      surfaceShape(SurfaceTree(ellipsoidSurface(Vec3::Constant(0.004), 0.0002)), SurfaceSide{}, 0.005);
  std::mt19937 random(3);
  for (int k = 0; k < 300; ++k) {
    const Vec3 x = 0.004 * (0.8 + 0.001 * k) * drawn(random).normalized();
    Vec3 normal;
    CHECK(shape.gapAt(x, normal) == Approx(x.norm() - 0.004).margin(6e-6));
  }
}

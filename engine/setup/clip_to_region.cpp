#include "setup/clip_to_region.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace palpate {
namespace {

constexpr int round_sides = 64;
constexpr double tolerance = 1e-9;  // m, as contains() has it

/// Part of a triangle: corners in barycentric coordinates.
using Polygon = std::vector<Vec3>;

/// Leaves what is where (x - point) . normal <= 0.
void cut(const std::array<Vec3, 3>& corner, const Vec3& point, const Vec3& normal, Polygon& polygon) {
  Vec3 height;  // of the triangle's corners
  for (int k = 0; k < 3; ++k) height[k] = (corner[static_cast<std::size_t>(k)] - point).dot(normal) - tolerance;
  if ((height.array() <= 0).all()) return;
  Polygon left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = height.dot(a), at_b = height.dot(b);
    if (at_a <= 0) left.push_back(a);
    if ((at_a < 0 && at_b > 0) || (at_a > 0 && at_b < 0)) left.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  polygon.swap(left);
}

/// Leaves what is in a prism of the area of a circle.
void cutRound(const std::array<Vec3, 3>& corner, const Vec3& centre, const Vec3& axis, double radius,
              Polygon& polygon) {
  constexpr double angle = 2 * std::numbers::pi / round_sides;
  // round_sides tan(pi / round_sides) inner^2 = pi radius^2
  const double inner = radius * std::sqrt(0.5 * angle / std::tan(0.5 * angle));
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  for (int k = 0; k < round_sides && !polygon.empty(); ++k) {
    const Vec3 out = std::cos(k * angle) * x + std::sin(k * angle) * y;
    cut(corner, centre + inner * out, out, polygon);
  }
}

}  // namespace

ClippedTriangle clipToRegion(const Region& region, const std::array<Vec3, 3>& corner) {
  const ClippedTriangle whole{1, Vec3::Constant(1.0 / 3)};
  if (std::all_of(corner.begin(), corner.end(), [&](const Vec3& x) { return region.contains(x); })) return whole;
  Polygon polygon{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  const auto keep = [&](const Vec3& point, const Vec3& normal) { cut(corner, point, normal, polygon); };
  switch (region.kind) {
    case Region::Kind::HalfSpace:
      keep(region.point, region.normal);
      break;
    case Region::Kind::NearPlane:
      for (const double side : {-1.0, 1.0})
        keep(region.point + side * region.distance * region.normal, side * region.normal);
      break;
    case Region::Kind::Box:
      for (int c = 0; c < 3; ++c) {
        keep(region.min, -Vec3::Unit(c));
        keep(region.max, Vec3::Unit(c));
      }
      break;
    case Region::Kind::Cylinder:
      keep(region.point, -region.normal);
      keep(region.point + region.height * region.normal, region.normal);
      cutRound(corner, region.point, region.normal, region.radius, polygon);
      break;
    case Region::Kind::Sphere: {  // a circle in the triangle's plane
      const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      if (normal.isZero(0)) return {};
      const double height = (region.point - corner[0]).dot(normal);
      const double squared = region.radius * region.radius - height * height;
      if (!(squared > 0)) return {};
      cutRound(corner, region.point - height * normal, normal, std::sqrt(squared), polygon);
      break;
    }
    case Region::Kind::Shell:
    case Region::Kind::Point:
      return {};
  }
  ClippedTriangle clipped;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
    const Vec3 a = polygon[i] - polygon[0], b = polygon[i + 1] - polygon[0];
    const double share = a[0] * b[1] - a[1] * b[0];
    clipped.share += share;
    clipped.barycentric += share / 3 * (polygon[0] + polygon[i] + polygon[i + 1]);
  }
  if (clipped.share > 0) clipped.barycentric /= clipped.share;
  return clipped;
}

}  // namespace palpate

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/types.h"

/// The vocabulary in which the organs are described: fields that are negative
/// inside a body, positive outside, and roughly a distance in m near its surface.
///
/// Every operation here is built from + - * / and sqrt, which IEEE 754 rounds the
/// same everywhere; sin, exp and pow are not, so they are kept out. With
/// contraction off (tools/CMakeLists.txt) an organ's file has the same bytes on
/// every machine and in every build mode.
namespace palpate::organs {

/// An ellipsoid around `centre`, m: first-order distance g / |grad g|, g = |p / semi_axes| - 1.
inline double ellipsoid(const Vec3& p, const Vec3& centre, const Vec3& semi_axes) {
  const Vec3 unit = (p - centre).cwiseQuotient(semi_axes);
  const double k = unit.norm();
  const double slope = unit.cwiseQuotient(semi_axes).norm();
  constexpr double kCentre = 1e-9;  // the gradient vanishes at the centre, far from the surface
  return slope < kCentre ? -semi_axes.minCoeff() : k * (k - 1) / slope;
}

/// The half-space behind a plane through `point` with outward `normal` (any length).
inline double halfSpace(const Vec3& p, const Vec3& point, const Vec3& normal) {
  return (p - point).dot(normal) / normal.norm();
}

/// Union whose inner corner is filled by a fillet. It is one branch of the hyperbola
/// (r - a)(r - b) = radius^2 / 4, so it is smooth to all orders: no crease, and no
/// line along which a highlight breaks. At the corner it gives radius / 2 more.
inline double smoothUnion(double a, double b, double radius) {
  return 0.5 * (a + b - std::sqrt((a - b) * (a - b) + radius * radius));
}

/// Intersection with a rounded edge; see smoothUnion.
inline double smoothIntersection(double a, double b, double radius) { return -smoothUnion(-a, -b, radius); }

/// `a` without `b`, with rounded edges.
inline double smoothDifference(double a, double b, double radius) { return smoothIntersection(a, -b, radius); }

/// A smooth bump: 1 at t = 0, falling to 0 at |t| >= 1 with two continuous derivatives.
inline double bump(double t) {
  const double s = std::max(0.0, 1 - t * t);
  return s * s * s;
}

/// Smooth deterministic noise in about -1..1 with features of size 1: gradients hashed
/// from the integer lattice, blended by 6 t^5 - 15 t^4 + 10 t^3 (two continuous derivatives).
inline double noise(const Vec3& p, std::uint32_t seed) {
  const auto hash = [seed](std::int32_t i, std::int32_t j, std::int32_t k) {
    std::uint32_t h = seed * 0x9e3779b9U;
    for (const std::int32_t c : {i, j, k}) {
      h = (h ^ static_cast<std::uint32_t>(c)) * 0x85ebca6bU;
      h ^= h >> 15U;
      h *= 0xc2b2ae35U;
      h ^= h >> 13U;
    }
    return h;
  };
  const Vec3 base = p.array().floor();
  const Vec3 t = p - base;
  const Vec3 blend = t.unaryExpr([](double s) { return s * s * s * (s * (6 * s - 15) + 10); });
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int d[3] = {corner & 1, (corner >> 1) & 1, (corner >> 2) & 1};
    const std::uint32_t h = hash(static_cast<std::int32_t>(base.x()) + d[0], static_cast<std::int32_t>(base.y()) + d[1],
                                 static_cast<std::int32_t>(base.z()) + d[2]);
    double weight = 1;
    double slope = 0;
    for (int a = 0; a < 3; ++a) {
      weight *= d[a] == 1 ? blend[a] : 1 - blend[a];
      const double gradient = static_cast<double>((h >> (10U * static_cast<unsigned>(a))) & 1023U) / 511.5 - 1;
      slope += gradient * (t[a] - d[a]);
    }
    sum += weight * slope;
  }
  return sum;
}

}  // namespace palpate::organs

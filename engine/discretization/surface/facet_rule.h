#pragma once

#include "base/types.h"

namespace palpate {

/// Dunavant's 6-point rule on a triangle, exact for polynomials of degree 4 (Int. J. Numer. Methods Eng. 21, 1985).
struct FacetRule {
  static constexpr int size = 6;
  static constexpr double a[2] = {0.445948490915965, 0.091576213509771};  // coordinates (a, a, 1 - 2a) in turn
  static constexpr double ring_weight[2] = {0.223381589678011, 0.109951743655322};

  /// Share of the area; the six sum to 1.
  static constexpr double weight(int k) { return ring_weight[k / 3]; }

  /// Barycentric coordinates of sample k: the corners' linear shape functions there.
  static Vec3 corners(int k) {
    Vec3 l = Vec3::Constant(a[k / 3]);
    l[k % 3] = 1 - 2 * a[k / 3];
    return l;
  }

  /// Sample k of the triangle with these corners.
  static Vec3 point(int k, const Vec3& p0, const Vec3& p1, const Vec3& p2) {
    const Vec3 l = corners(k);
    return l[0] * p0 + l[1] * p1 + l[2] * p2;
  }
};

}  // namespace palpate

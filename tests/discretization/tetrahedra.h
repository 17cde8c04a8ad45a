#pragma once

#include <Eigen/LU>

#include <cmath>

#include "discretization/cells/cell_division.h"

namespace palpate {

/// No symmetry, no right angle.
inline const Corners general = {Vec3(0.1, -0.2, 0.3), Vec3(1.3, 0.2, 0.1), Vec3(0.4, 1.1, -0.2), Vec3(0.2, 0.3, 1.7)};

inline double volumeOf(const Corners& c) { return std::abs((c[1] - c[0]).cross(c[2] - c[0]).dot(c[3] - c[0])) / 6; }

inline Vec3 centroid(const Corners& c) { return (c[0] + c[1] + c[2] + c[3]) / 4; }

inline bool holds(const Corners& c, const Vec3& x) {
  Mat3 edges;
  edges << c[1] - c[0], c[2] - c[0], c[3] - c[0];
  const Vec3 l = edges.inverse() * (x - c[0]);
  return l.minCoeff() > 0 && l.sum() < 1;
}

}  // namespace palpate

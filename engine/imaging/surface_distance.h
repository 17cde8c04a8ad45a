#pragma once

#include <functional>
#include <vector>

#include "discretization/surface/surface_tree.h"

namespace palpate {

/// Points of a surface, spread evenly over its area, and the faces they lie in. The same at each call.
struct SurfacePoints {
  std::vector<Vec3> x;    // (count) m
  std::vector<int> face;  // (count)
};
SurfacePoints pointsOn(const TriangleSurface& surface, int count);

/// How far points are from a surface.
struct SurfaceDistance {
  double mean = 0, p95 = 0, max = 0;  // m
  int count = 0;
  int furthest = -1;  // the point with the largest

  /// Share of the points further away than `distance`.
  double shareBeyond(double distance) const;

  std::vector<double> sorted;  // (count) m
};
SurfaceDistance distanceTo(const SurfaceTree& surface, const std::vector<Vec3>& points);

}  // namespace palpate

#pragma once

#include <functional>

#include "discretization/triangle_surface.h"

namespace palpate {

/// The longest edge wanted around a point, m; positive.
using EdgeLengthAt = std::function<double(const Vec3& x)>;

/// Splits edges at their midpoints, longest first, until none is longer than `longest_at` says at
/// its midpoint. Vertices 0 .. n-1 stay; the surface keeps its shape, volume, orientation
/// and closedness (no hanging vertices). Splitting the longest edge first bounds the smallest angle to
/// half of the original one (Rosenberg and Stenger 1975).
/// Throws std::invalid_argument for lengths that are not positive, std::length_error beyond `max_triangles`.
TriangleSurface refineSurface(const TriangleSurface& surface, const EdgeLengthAt& longest_at,
                              int max_triangles = 4'000'000);

/// The same with one length everywhere, m.
TriangleSurface refineSurface(const TriangleSurface& surface, double longest);

}  // namespace palpate

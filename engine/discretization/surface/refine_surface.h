#pragma once

#include <functional>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// The longest edge wanted around a point, m; positive.
using EdgeLengthAt = std::function<double(const Vec3& x)>;

/// Beyond this many faces a surface takes gigabytes, and a contact with it seconds.
inline constexpr int max_refined_triangles = 4'000'000;

/// Halves edges until none is longer than the smallest value of `longest_at` at its two ends and its
/// midpoint. The given vertices stay, with their numbers; the surface keeps its shape, volume, orientation
/// and closedness (no vertex is left hanging in an edge). An edge is only halved when it is the longest
/// of both its faces, so no angle falls below half the smallest given one (Rosenberg and Stenger 1975,
/// Rivara 1984). Works on open surfaces, too; deterministic.
/// Throws std::invalid_argument for a length that is not positive, std::length_error where more
/// than `max_triangles` would be needed.
TriangleSurface refineSurface(const TriangleSurface& surface, const EdgeLengthAt& longest_at,
                              int max_triangles = max_refined_triangles);

/// The same with one length everywhere, m.
TriangleSurface refineSurface(const TriangleSurface& surface, double longest);

}  // namespace palpate

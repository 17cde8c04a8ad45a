#pragma once

#include <array>

#include "scene/scene.h"

namespace palpate {

/// What of a triangle lies in a region.
struct ClippedTriangle {
  double share = 0;                 // of its area
  Vec3 barycentric = Vec3::Zero();  // of the middle of that part
};

/// Cuts a triangle (corners in m) along the borders of a region, which is a convex one, not a shell or a point. Planes
/// cut exactly; a sphere and a cylinder are prisms of 64 sides and of the same area.
/// Test: simulation/clip_to_region_test.cpp
ClippedTriangle clipToRegion(const Region& region, const std::array<Vec3, 3>& corner);

}  // namespace palpate

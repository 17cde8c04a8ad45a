#pragma once

#include <optional>
#include <vector>

#include "discretization/surface/surface_tree.h"

namespace palpate {

/// The air between parts of a body's skin that look at each other: a fold, a slit, the space below a flap. What a point
/// of the tissue follows must not be on the other side of it, however near (Belytschko et al. 1996, visibility of
/// supports across cracks). Immutable; any number of threads may ask.
class SurfaceGaps {
 public:
  /// No gaps.
  SurfaceGaps() = default;

  /// @param skin    of the body, m, in faces that are small beside its gaps
  /// @param body    its closed surface
  /// @param widest  m, that a gap may be
  SurfaceGaps(const TriangleSurface& skin, const SurfaceTree& body, double widest);

  bool empty() const { return !screens_; }

  /// Whether a gap is within a distance of x, m.
  bool areNear(const Vec3& x, double distance) const {
    return screens_ && screens_->closest(x, distance).triangle >= 0;
  }
  /// Whether the straight way from a to b, m, leads across a gap.
  bool areBetween(const Vec3& a, const Vec3& b) const;

 private:
  /// In each gap, before each of its two sides.
  std::optional<SurfaceTree> screens_;
};

/// Straight across the air from x, m, a point of the body's skin: the points that look at it from within `widest`, one
/// for each face at x that looks at skin (an edge may look at two).
std::vector<Vec3> acrossAir(const SurfaceTree& body, const Vec3& x, double widest);

/// m, from the middle of each face straight through a body to skin that looks the other way (face_count); infinity
/// where there is none.
/// @param skin  faces of the body's surface, or parts of them
std::vector<double> thicknesses(const TriangleSurface& skin, const SurfaceTree& body);

/// How thick a body is at most, m, where a share of its skin is thinnest; infinity where less has a thickness.
double thicknessOf(const SurfaceTree& body, double share);

}  // namespace palpate

#pragma once

#include <vector>

#include "discretization/surface/surface_tree.h"

namespace palpate::app {

/// The skin at rest as something to glide over: the nearest place of it, with a normal that turns evenly.
class SkinSurface {
 public:
  explicit SkinSurface(const TriangleSurface& surface);

  struct Place {
    Vec3 point = Vec3::Zero();    // m, at rest
    Vec3 normal = Vec3::UnitZ();  // unit, outward, smoothed over the neighbours
  };

  /// The place nearest to x, m. Where there are no triangles: x itself.
  Place nearest(const Vec3& x) const;

 private:
  SurfaceTree tree_;
  std::vector<Vec3> normal_;  // (vertex_count)
};

}  // namespace palpate::app

#pragma once

#include <vector>

#include "base/types.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// The sharp lines of a surface, which a node cloud must follow so that its cells keep the shape.
struct FeatureEdges {
  struct Chain {
    std::vector<Vec3> points;  // polyline, m; a closed one repeats its first point at the end
    bool closed = false;
  };
  std::vector<Vec3> corners;  // where chains end, meet or turn sharply, m
  std::vector<Chain> chains;  // open ones run from corner to corner
};

/// Finds the edges at which the faces' normals differ by more than 40 degrees, and links them.
FeatureEdges findFeatureEdges(const TriangleSurface& surface);

}  // namespace palpate

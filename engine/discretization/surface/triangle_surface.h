#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// A triangle surface; for an organ it is closed, with outward normals
/// (counter-clockwise seen from outside). Positions in m.
struct TriangleSurface {
  std::vector<Vec3> vertices;                 // (vertex_count)
  std::vector<std::array<int, 3>> triangles;  // (triangle_count)
  std::vector<int> organ{};                   // (triangle_count) of several organs the one that it is of; empty: of one
};

}  // namespace palpate

#pragma once

#include <array>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Edges and faces of the skin and which vertices they join: constant.
struct SkinTopology {
  // Edges, ascending by their vertices.
  std::vector<std::array<int, 2>> edge;  // (edge_count) vertices, the lower first
  std::vector<float> edge_length;        // (edge_count) m, reference configuration
  std::vector<int> edge_begin;           // (vertex_count + 1) of the edges whose lower vertex is v

  // Faces, in the order of the surface's triangles.
  std::vector<std::array<int, 3>> face_edge;  // (face_count) the edge opposite to each corner
  std::vector<int> face_begin;                // (vertex_count + 1) into `face_of`
  std::vector<int> face_of;                   // (3 face_count) the faces around each vertex, ascending

  int edgeCount() const { return static_cast<int>(edge.size()); }
  int faceCount() const { return static_cast<int>(face_edge.size()); }
};

/// For set-up. Test: contact/face_samples_test.cpp.
SkinTopology makeSkinTopology(const TriangleSurface& surface);

}  // namespace palpate

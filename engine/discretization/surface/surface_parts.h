#pragma once

#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// An edge of one face, with its direction in that face.
struct FaceEdge {
  int low = 0, high = 0;  // its vertices, low < high
  int triangle = 0;
  bool forward = true;  // the face runs from low to high
};

/// The three edges of each face, sorted by (low, high, triangle): faces that share an edge stand together.
std::vector<FaceEdge> faceEdges(const TriangleSurface& surface);

/// Calls visit(first, count) for each edge of the surface: `first` points to the first of its faces' `count` entries.
template <class Visit>
void forEachEdge(const std::vector<FaceEdge>& edges, Visit visit) {
  for (auto first = edges.begin(), end = first; first != edges.end(); first = end) {
    while (end != edges.end() && end->low == first->low && end->high == first->high) ++end;
    visit(&*first, static_cast<int>(end - first));
  }
}

/// The surface's parts: faces connected across edges, and their sense of rotation.
struct SurfaceParts {
  int count = 0;
  std::vector<int> part;        // (triangle_count) 0 .. count-1, in order of their first faces
  std::vector<char> turned;     // (triangle_count) 1 where a face runs against its part's first face
  std::vector<char> one_sided;  // (count) 1 where no consistent orientation exists
};

/// @param edges  of faceEdges, at most two faces at each edge
SurfaceParts connectedParts(const TriangleSurface& surface, const std::vector<FaceEdge>& edges);

/// The parts as surfaces of their own, each with the vertices it uses. (parts.count)
std::vector<TriangleSurface> separateParts(const TriangleSurface& surface, const SurfaceParts& parts);

}  // namespace palpate

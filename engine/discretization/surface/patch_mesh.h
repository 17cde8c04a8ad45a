#pragma once

#include <functional>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// A triangle surface made of smooth patches that meet in sharp edges: what solids are built in.
struct PatchMesh {
  TriangleSurface surface;
  std::vector<int> vertex_patch;  // (vertex_count) the patch it may slide in; held_vertex: it stays
  std::vector<int> face_patch;    // (triangle_count)

  static constexpr int held_vertex = -1;

  int addVertex(const Vec3& x, int patch);

  /// Fills the strip between two closed rings of vertices, both counter-clockwise when seen against the
  /// direction from `lower` to `upper` turned outward: faces run lower[i], lower[i+1], upper[j]. A ring
  /// of one vertex is a pole.
  void bridgeRings(const std::vector<int>& lower, const std::vector<int>& upper, int patch);

  /// The same between two open rows.
  void bridgeRows(const std::vector<int>& lower, const std::vector<int>& upper, int patch);

  /// Makes the triangles near-equilateral: by turns swaps the diagonals of neighbouring faces of one patch
  /// where that widens the smallest angle (Delaunay), and moves each free vertex to the centroid of its faces.
  /// @param project  the point of a patch near a point
  void relax(const std::function<Vec3(int patch, const Vec3& x)>& project, int rounds = 12);

 private:
  void addFace(int a, int b, int c, int patch);
  int swapDiagonals();
};

}  // namespace palpate

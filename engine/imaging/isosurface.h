#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Negative inside a body, positive outside, roughly a distance; m.
using Field = std::function<double(const Vec3&)>;

/// A field's values on a regular grid; node n = i + nx (j + ny k).
struct SampledField {
  Vec3 origin = Vec3::Zero();      // m, of node 0
  double cell = 1;                 // m
  std::array<int, 3> count{};      // nodes along x, y, z
  std::vector<double> value = {};  // (nx * ny * nz)

  int node(int i, int j, int k) const { return i + count[0] * (j + count[1] * k); }
  Vec3 position(int n) const {
    const int i = n % count[0];
    const int j = n / count[0] % count[1];
    const int k = n / count[0] / count[1];
    return origin + cell * Vec3(i, j, k);
  }
  bool onBox(int i, int j, int k) const {
    return i == 0 || j == 0 || k == 0 || i == count[0] - 1 || j == count[1] - 1 || k == count[2] - 1;
  }

  /// Between the nodes, trilinear; beyond the grid as on its nearest side.
  double at(const Vec3& x) const;
};

/// `field` at the nodes of a grid from `min` on that ends within a cell of `max`, m.
SampledField sampleField(const Field& field, const Vec3& min, const Vec3& max, double cell);

/// Whether the field is negative somewhere on its grid's outermost nodes, so that the body may go on beyond them.
bool reachesBox(const SampledField& field);

/// The zero level of a field, by marching tetrahedra: closed and manifold where !reachesBox(field), and never through
/// itself; outward normals, uneven triangles (remesh.h makes them even). Each vertex lies on an edge of a tetrahedron,
/// at least a twentieth of it from its ends. Costs ~ node count.
TriangleSurface isosurface(const SampledField& field);

}  // namespace palpate

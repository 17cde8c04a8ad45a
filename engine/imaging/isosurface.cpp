#include "imaging/isosurface.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace palpate {
namespace {

class Marcher {
 public:
  explicit Marcher(const SampledField& grid) : grid_(grid) {}

  /// The part of the surface in one tetrahedron of grid nodes.
  void march(const std::array<int, 4>& tet) {
    std::array<int, 4> in{};
    std::array<int, 4> out{};
    int in_count = 0;
    int out_count = 0;
    for (const int n : tet) {
      if (inside(n)) {
        in[in_count++] = n;
      } else {
        out[out_count++] = n;
      }
    }
    if (in_count == 1) {
      add(in[0], out[0], out[1], out[2], crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2]));
    } else if (in_count == 3) {
      add(in[0], out[0], out[0], out[0], crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0]));
    } else if (in_count == 2) {
      // The section is the quadrilateral 00 01 11 10; cut along 00-11.
      const int v00 = crossing(in[0], out[0]);
      const int v01 = crossing(in[0], out[1]);
      const int v11 = crossing(in[1], out[1]);
      const int v10 = crossing(in[1], out[0]);
      add(in[0], out[0], out[1], out[1], v00, v01, v11);
      add(in[0], out[0], out[1], out[1], v00, v11, v10);
    }
  }

  TriangleSurface take() { return std::move(surface_); }

 private:
  bool inside(int n) const { return grid_.value[n] < 0; }

  /// The surface vertex on the grid edge between an inner and an outer node.
  int crossing(int in, int out) {
    const std::uint64_t key =
        static_cast<std::uint64_t>(std::min(in, out)) << 32U | static_cast<std::uint64_t>(std::max(in, out));
    const auto [entry, is_new] = vertex_of_edge_.try_emplace(key, static_cast<int>(surface_.vertices.size()));
    if (is_new) {
      // Kept off the nodes, so that no triangle collapses to a point.
      const double t = grid_.value[in] / (grid_.value[in] - grid_.value[out]);
      const Vec3 a = grid_.position(in);
      surface_.vertices.push_back(a + std::clamp(t, 0.05, 0.95) * (grid_.position(out) - a));
    }
    return entry->second;
  }

  /// Adds a triangle, turned to face from the inner node towards the mean of three outer ones.
  void add(int in, int out0, int out1, int out2, int a, int b, int c) {
    const auto& x = surface_.vertices;
    const Vec3 normal = (x[b] - x[a]).cross(x[c] - x[a]);
    const Vec3 outward = (grid_.position(out0) + grid_.position(out1) + grid_.position(out2)) / 3 - grid_.position(in);
    if (normal.dot(outward) < 0) std::swap(b, c);
    surface_.triangles.push_back({a, b, c});
  }

  const SampledField& grid_;
  TriangleSurface surface_;
  std::unordered_map<std::uint64_t, int> vertex_of_edge_;
};

}  // namespace

double SampledField::at(const Vec3& x) const {
  std::array<int, 3> low{};
  Vec3 t;
  for (int a = 0; a < 3; ++a) {
    const double u = std::clamp((x[a] - origin[a]) / cell, 0.0, static_cast<double>(count[a] - 1));
    low[a] = std::min(static_cast<int>(u), std::max(0, count[a] - 2));
    t[a] = u - low[a];
  }
  const auto along = [](double a, double b, double s) { return a + s * (b - a); };
  const auto row = [&](int j, int k) {
    const std::size_t n =
        static_cast<std::size_t>(node(low[0], std::min(low[1] + j, count[1] - 1), std::min(low[2] + k, count[2] - 1)));
    return along(value[n], value[n + (count[0] > 1 ? 1 : 0)], t[0]);
  };
  return along(along(row(0, 0), row(1, 0), t[1]), along(row(0, 1), row(1, 1), t[1]), t[2]);
}

SampledField sampleField(const Field& field, const Vec3& min, const Vec3& max, double cell) {
  SampledField grid{min, cell};
  for (int a = 0; a < 3; ++a) grid.count[a] = 1 + static_cast<int>((max[a] - min[a]) / cell);
  grid.value.resize(static_cast<std::size_t>(grid.count[0]) * grid.count[1] * grid.count[2]);
  for (std::size_t n = 0; n < grid.value.size(); ++n) grid.value[n] = field(grid.position(static_cast<int>(n)));
  return grid;
}

bool reachesBox(const SampledField& field) {
  const auto& [nx, ny, nz] = field.count;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        if (field.onBox(i, j, k) && field.value[field.node(i, j, k)] < 0) return true;
  return false;
}

TriangleSurface isosurface(const SampledField& field) {
  const auto& [nx, ny, nz] = field.count;
  Marcher marcher(field);
  // Each cell is cut into the six tetrahedra that climb from its low corner to its high
  // one, an axis at a time in each order; neighbouring cells then agree on shared faces.
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k + 1 < nz; ++k) {
    for (int j = 0; j + 1 < ny; ++j) {
      for (int i = 0; i + 1 < nx; ++i) {
        int inner = 0;
        for (int corner = 0; corner < 8; ++corner)
          inner += field.value[field.node(i + corner % 2, j + corner / 2 % 2, k + corner / 4)] < 0 ? 1 : 0;
        if (inner == 0 || inner == 8) continue;
        for (const auto& order : kOrders) {
          std::array<int, 3> corner = {i, j, k};
          std::array<int, 4> tet{};
          tet[0] = field.node(i, j, k);
          for (int s = 0; s < 3; ++s) {
            ++corner[order[s]];
            tet[s + 1] = field.node(corner[0], corner[1], corner[2]);
          }
          marcher.march(tet);
        }
      }
    }
  }
  return marcher.take();
}

}  // namespace palpate

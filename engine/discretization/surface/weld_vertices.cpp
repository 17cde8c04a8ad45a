#include "discretization/surface/weld_vertices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Vertices in the cells of a grid, to be taken out near a place.
class VertexCells {
 public:
  /// @param size  of a cell, m; at least the distance that is asked for
  VertexCells(const std::vector<Vec3>& vertices, double size)
      : vertices_(vertices), size_(size > 0 ? size : 1), next_(vertices.size(), none), held_(vertices.size(), 1) {
    for (const Vec3& x : vertices) low_ = low_.cwiseMin(x);
    first_.reserve(vertices.size());
    for (int v = static_cast<int>(vertices.size()) - 1; v >= 0; --v)
      next_[v] = std::exchange(first_.try_emplace(keyOf(cellOf(vertices[v])), none).first->second, v);
  }

  bool holds(int v) const { return held_[v] != 0; }

  /// Takes the vertices within `distance` of vertex v, itself included, and appends them.
  void takeWithin(int v, double distance, std::vector<int>& taken) {
    const Cell middle = cellOf(vertices_[v]);
    for (std::int64_t x = middle[0] - 1; x <= middle[0] + 1; ++x)
      for (std::int64_t y = middle[1] - 1; y <= middle[1] + 1; ++y)
        for (std::int64_t z = middle[2] - 1; z <= middle[2] + 1; ++z) {
          const auto cell = first_.find(keyOf({x, y, z}));
          if (cell == first_.end()) continue;
          for (int* at = &cell->second; *at != none;) {
            const int other = *at;
            if ((vertices_[other] - vertices_[v]).norm() <= distance) {
              taken.push_back(other);
              held_[other] = 0;
              *at = next_[other];
            } else {
              at = &next_[other];
            }
          }
        }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  static constexpr int none = -1;

  Cell cellOf(const Vec3& x) const {
    Cell cell;
    for (int c = 0; c < 3; ++c) cell[c] = static_cast<std::int64_t>(std::floor((x[c] - low_[c]) / size_));
    return cell;
  }
  /// Two cells may have the same; then their vertices stand in one list.
  static std::uint64_t keyOf(const Cell& cell) {
    std::uint64_t key = 0;
    for (const std::int64_t c : cell) key = (key ^ static_cast<std::uint64_t>(c)) * 0x9E3779B97F4A7C15ull;
    return key ^ (key >> 32);
  }

  const std::vector<Vec3>& vertices_;
  double size_;
  Vec3 low_ = Vec3::Constant(std::numeric_limits<double>::infinity());
  std::unordered_map<std::uint64_t, int> first_;  // vertex of a cell's list
  std::vector<int> next_;                         // (vertex_count) in that list
  std::vector<char> held_;                        // (vertex_count)
};

}  // namespace

int weldVertices(TriangleSurface& surface, SurfaceSource& source) {
  const int count = static_cast<int>(surface.vertices.size());
  for (const Vec3& v : surface.vertices) {
    if (!v.allFinite()) return 0;
  }
  const double diagonal = boundingBox(surface).diagonal().norm();
  const double tolerance = 1e-6 * diagonal;
  if (!std::isfinite(diagonal)) return 0;

  // In an order that no usual model is aligned with, each vertex takes those near it that no earlier one took.
  const Vec3 direction = Vec3(0.4171, 0.6853, 0.5970).normalized();
  std::vector<double> along(count);
  for (int v = 0; v < count; ++v) along[v] = direction.dot(surface.vertices[v]);
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int v, int w) { return along[v] < along[w] || (along[v] == along[w] && v < w); });
  std::vector<int> joined(count);  // the lowest vertex of each group
  std::iota(joined.begin(), joined.end(), 0);
  VertexCells cells(surface.vertices, tolerance);
  std::vector<int> group;
  for (const int first : order) {
    if (!cells.holds(first)) continue;
    group.clear();
    cells.takeWithin(first, tolerance, group);
    const int lowest = *std::min_element(group.begin(), group.end());
    for (int v : group) joined[v] = lowest;
  }

  for (auto& triangle : surface.triangles)
    for (int& v : triangle) v = joined[v];
  dropUnusedVertices(surface, source);
  return count - static_cast<int>(surface.vertices.size());
}

void dropUnusedVertices(TriangleSurface& surface, SurfaceSource& source) {
  std::vector<int> number(surface.vertices.size(), -1);
  for (const auto& t : surface.triangles)
    for (const int v : t) number[v] = 0;
  int kept = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = kept;
    surface.vertices[kept] = surface.vertices[v];
    if (!source.vertex_line.empty()) source.vertex_line[kept] = source.vertex_line[v];
    ++kept;
  }
  surface.vertices.resize(kept);
  if (!source.vertex_line.empty()) source.vertex_line.resize(kept);
  for (auto& t : surface.triangles)
    for (int& v : t) v = number[v];
}

}  // namespace palpate

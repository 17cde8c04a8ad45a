#include "contact/samples/skin_topology.h"

#include <algorithm>
#include <numeric>

namespace palpate {

SkinTopology makeSkinTopology(const TriangleSurface& surface) {
  SkinTopology t;
  for (const auto& corners : surface.triangles) {
    for (int c = 0; c < 3; ++c) {
      const int a = corners[(c + 1) % 3], b = corners[(c + 2) % 3];
      t.edge.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  std::sort(t.edge.begin(), t.edge.end());
  t.edge.erase(std::unique(t.edge.begin(), t.edge.end()), t.edge.end());

  const std::size_t vertices = surface.vertices.size();
  t.edge_begin.assign(vertices + 1, 0);
  t.face_begin.assign(vertices + 1, 0);
  for (const auto& [a, b] : t.edge) {
    t.edge_length.push_back(static_cast<float>((surface.vertices[b] - surface.vertices[a]).norm()));
    ++t.edge_begin[a + 1];
  }
  for (const auto& corners : surface.triangles) {
    std::array<int, 3>& edges = t.face_edge.emplace_back();
    for (int c = 0; c < 3; ++c) {
      const int a = corners[(c + 1) % 3], b = corners[(c + 2) % 3];
      const std::array<int, 2> ends{std::min(a, b), std::max(a, b)};
      edges[c] = static_cast<int>(std::lower_bound(t.edge.begin(), t.edge.end(), ends) - t.edge.begin());
      ++t.face_begin[corners[c] + 1];
    }
  }
  std::partial_sum(t.edge_begin.begin(), t.edge_begin.end(), t.edge_begin.begin());
  std::partial_sum(t.face_begin.begin(), t.face_begin.end(), t.face_begin.begin());
  t.face_of.resize(3 * surface.triangles.size());
  std::vector<int> next(t.face_begin.begin(), t.face_begin.end() - 1);
  for (int f = 0; f < t.faceCount(); ++f)
    for (const int v : surface.triangles[f]) t.face_of[next[v]++] = f;
  return t;
}

}  // namespace palpate

#include "discretization/surface/surface_parts.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

namespace palpate {

std::vector<FaceEdge> faceEdges(const TriangleSurface& surface) {
  std::vector<FaceEdge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& triangle = surface.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const int v = triangle[k], w = triangle[(k + 1) % 3];
      edges.push_back({std::min(v, w), std::max(v, w), t, v < w});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const FaceEdge& a, const FaceEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

SurfaceParts connectedParts(const TriangleSurface& surface, const std::vector<FaceEdge>& edges) {
  const int count = static_cast<int>(surface.triangles.size());
  struct Neighbour {
    int triangle = -1;
    bool against = false;  // both run along the shared edge in the same direction
  };
  std::vector<std::array<Neighbour, 3>> neighbours(count);
  std::vector<char> neighbour_count(count, 0);
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const FaceEdge &a = edges[i], &b = edges[i + 1];
    if (a.low != b.low || a.high != b.high) continue;
    const bool against = a.forward == b.forward;
    neighbours[a.triangle][neighbour_count[a.triangle]++] = {b.triangle, against};
    neighbours[b.triangle][neighbour_count[b.triangle]++] = {a.triangle, against};
    ++i;
  }

  SurfaceParts parts;
  parts.part.assign(count, -1);
  parts.turned.assign(count, 0);
  std::vector<int> open;
  for (int seed = 0; seed < count; ++seed) {
    if (parts.part[seed] >= 0) continue;
    parts.part[seed] = parts.count;
    parts.one_sided.push_back(0);
    open.assign(1, seed);
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      for (int k = 0; k < neighbour_count[t]; ++k) {
        const auto [other, against] = neighbours[t][k];
        const char turned = static_cast<char>(parts.turned[t] ^ static_cast<char>(against));
        if (parts.part[other] < 0) {
          parts.part[other] = parts.count;
          parts.turned[other] = turned;
          open.push_back(other);
        } else if (parts.turned[other] != turned) {
          parts.one_sided[parts.count] = 1;
        }
      }
    }
    ++parts.count;
  }
  return parts;
}

std::vector<TriangleSurface> separateParts(const TriangleSurface& surface, const SurfaceParts& parts) {
  std::vector<int> order(surface.triangles.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int s, int t) { return parts.part[s] < parts.part[t]; });
  std::vector<TriangleSurface> pieces(parts.count);
  std::vector<int> local(surface.vertices.size(), -1), owner(surface.vertices.size(), -1);
  for (int t : order) {
    const int p = parts.part[t];
    TriangleSurface& piece = pieces[p];
    std::array<int, 3> triangle = surface.triangles[t];
    for (int& v : triangle) {
      if (owner[v] != p) {
        owner[v] = p;
        local[v] = static_cast<int>(piece.vertices.size());
        piece.vertices.push_back(surface.vertices[v]);
      }
      v = local[v];
    }
    piece.triangles.push_back(triangle);
    if (!surface.organ.empty()) piece.organ.push_back(surface.organ[t]);
  }
  return pieces;
}

}  // namespace palpate

#include "discretization/surface/patch_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"

namespace palpate {

int PatchMesh::addVertex(const Vec3& x, int patch) {
  surface.vertices.push_back(x);
  vertex_patch.push_back(patch);
  return static_cast<int>(surface.vertices.size()) - 1;
}

void PatchMesh::addFace(int a, int b, int c, int patch) {
  surface.triangles.push_back({a, b, c});
  face_patch.push_back(patch);
}

void PatchMesh::bridgeRows(const std::vector<int>& lower, const std::vector<int>& upper, int patch) {
  const auto distance = [&](int v, int w) { return (surface.vertices[v] - surface.vertices[w]).squaredNorm(); };
  std::size_t i = 0, j = 0;
  while (i + 1 < lower.size() || j + 1 < upper.size()) {
    const bool along_lower = j + 1 >= upper.size() || (i + 1 < lower.size() && distance(lower[i + 1], upper[j]) <=
                                                                                   distance(lower[i], upper[j + 1]));
    if (along_lower) {
      addFace(lower[i], lower[i + 1], upper[j], patch);
      ++i;
    } else {
      addFace(lower[i], upper[j + 1], upper[j], patch);
      ++j;
    }
  }
}

void PatchMesh::bridgeRings(const std::vector<int>& lower, const std::vector<int>& upper, int patch) {
  const auto cutOpen = [&](const std::vector<int>& ring, int nearest_to) {
    const auto start = std::min_element(ring.begin(), ring.end(), [&](int v, int w) {
      const Vec3& x = surface.vertices[nearest_to];
      return (surface.vertices[v] - x).squaredNorm() < (surface.vertices[w] - x).squaredNorm();
    });
    std::vector<int> row(start, ring.end());
    row.insert(row.end(), ring.begin(), start);
    if (row.size() > 1) row.push_back(row.front());
    return row;
  };
  const std::vector<int> low = cutOpen(lower, lower.front());
  bridgeRows(low, cutOpen(upper, lower.front()), patch);
}

int PatchMesh::swapDiagonals() {
  const auto& X = surface.vertices;
  const std::vector<FaceEdge> edges = faceEdges(surface);
  std::set<std::pair<int, int>> fresh;  // edges made in this pass
  const auto exists = [&](int v, int w) {
    const std::pair<int, int> key = std::minmax(v, w);
    const auto at = std::lower_bound(edges.begin(), edges.end(), key,
                                     [](const FaceEdge& e, const auto& k) { return std::pair(e.low, e.high) < k; });
    return (at != edges.end() && at->low == key.first && at->high == key.second) || fresh.count(key) > 0;
  };
  const auto angle = [&](int at, int v, int w) {
    const Vec3 e = X[v] - X[at], f = X[w] - X[at];
    return std::atan2(e.cross(f).norm(), e.dot(f));
  };
  const auto normal = [&](int a, int b, int c) { return Vec3((X[b] - X[a]).cross(X[c] - X[a])); };

  std::vector<char> touched(surface.triangles.size(), 0);
  int swapped = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const FaceEdge &one = edges[i], &two = edges[i + 1];
    if (one.low != two.low || one.high != two.high) continue;
    const int s = one.forward ? one.triangle : two.triangle, t = one.forward ? two.triangle : one.triangle;
    if (touched[s] || touched[t] || face_patch[s] != face_patch[t]) continue;
    const auto apex = [&](int face) {
      for (int v : surface.triangles[face]) {
        if (v != one.low && v != one.high) return v;
      }
      return -1;
    };
    // s = (v, w, x) and t = (w, v, y) become (x, v, y) and (y, w, x).
    const int v = one.low, w = one.high, x = apex(s), y = apex(t);
    constexpr double rounding = 1e-9;
    if (angle(x, v, w) + angle(y, v, w) <= std::numbers::pi + rounding || exists(x, y)) continue;
    const Vec3 mean = normal(v, w, x) + normal(w, v, y);
    if (normal(x, v, y).dot(mean) <= 0 || normal(y, w, x).dot(mean) <= 0) continue;
    surface.triangles[s] = {x, v, y};
    surface.triangles[t] = {y, w, x};
    touched[s] = touched[t] = 1;
    fresh.insert(std::minmax(x, y));
    ++swapped;
  }
  return swapped;
}

void PatchMesh::relax(const std::function<Vec3(int patch, const Vec3& x)>& project, int rounds) {
  constexpr int max_passes = 10;  // each swap may enable another next to it; a few passes settle
  const auto swapAll = [&] {
    for (int pass = 0; pass < max_passes && swapDiagonals() > 0; ++pass) {
    }
  };
  for (int round = 0; round < rounds; ++round) {
    swapAll();
    std::vector<Vec3> sum(surface.vertices.size(), Vec3::Zero());
    std::vector<double> weight(surface.vertices.size(), 0);
    for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
      const auto& [a, b, c] = surface.triangles[t];
      const Vec3 centroid = (surface.vertices[a] + surface.vertices[b] + surface.vertices[c]) / 3.0;
      const double area = areaVector(surface, t).norm();
      for (int v : surface.triangles[t]) {
        sum[v] += area * centroid;
        weight[v] += area;
      }
    }
    for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
      if (vertex_patch[v] == held_vertex || !(weight[v] > 0)) continue;
      surface.vertices[v] = project(vertex_patch[v], sum[v] / weight[v]);
    }
  }
  swapAll();
}

}  // namespace palpate

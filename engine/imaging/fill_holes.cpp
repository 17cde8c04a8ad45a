#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "base/parallel_for.h"
#include "discretization/surface/polygon_triangles.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/mend_surface.h"

namespace palpate {
namespace {

// Rims of more corners than this are filled as nearly flat polygons, since the smallest fill takes too long.
constexpr int most_for_smallest_fill = 120;

/// The rims of holes: closed curves of open edges, each against its face's sense, so that a fill turns as they do.
std::vector<std::vector<int>> rimsOf(const TriangleSurface& surface, int& crowded) {
  std::unordered_map<int, std::vector<int>> next;
  std::vector<int> starts;
  crowded = 0;
  forEachEdge(faceEdges(surface), [&](const FaceEdge* edge, int count) {
    if (count > 2) ++crowded;
    if (count != 1) return;
    const int from = edge->forward ? edge->high : edge->low;
    next[from].push_back(edge->forward ? edge->low : edge->high);
    starts.push_back(from);
  });
  std::vector<std::vector<int>> rims;
  std::unordered_map<int, std::size_t> place;  // of a vertex on the way
  for (const int start : starts) {
    std::vector<int> way = {start};
    place.clear();
    place[start] = 0;
    for (;;) {
      auto& out = next[way.back()];
      if (out.empty()) break;  // the curve does not close
      const int to = out.back();
      out.pop_back();
      const auto met = place.find(to);
      if (met == place.end()) {
        place[to] = way.size();
        way.push_back(to);
        continue;
      }
      // Where the way meets itself, what lies between is a rim of its own.
      const std::size_t first = met->second;
      rims.emplace_back(way.begin() + static_cast<long>(first), way.end());
      for (std::size_t k = first + 1; k < way.size(); ++k) place.erase(way[k]);
      way.resize(first + 1);
    }
  }
  return rims;
}

struct Fill {
  std::vector<std::array<int, 3>> faces;
  double area = 0;
  int edges = 0;
};

Fill fillOf(const TriangleSurface& surface, const std::vector<int>& rim, CutBudget& budget) {
  Fill fill;
  fill.edges = static_cast<int>(rim.size());
  std::vector<Vec3> corners;
  corners.reserve(rim.size());
  for (const int v : rim) corners.push_back(surface.vertices[v]);
  const auto triangles =
      fill.edges <= most_for_smallest_fill ? smallestFill(corners) : polygonTriangles(corners, budget);
  for (const auto& [a, b, c] : triangles) {
    fill.faces.push_back({rim[a], rim[b], rim[c]});
    fill.area += 0.5 * (corners[b] - corners[a]).cross(corners[c] - corners[a]).norm();
  }
  return fill;
}

}  // namespace

int fillHoles(TriangleSurface& surface, SurfaceSource& source, RepairReport& report) {
  const int given = static_cast<int>(surface.triangles.size());
  std::vector<Fill> fills;
  CutBudget budget;
  for (const std::vector<int>& rim : rimsOf(surface, report.crowded_edges)) {
    SetupWatch::check();
    if (rim.size() >= 3) fills.push_back(fillOf(surface, rim, budget));
  }
  std::stable_sort(fills.begin(), fills.end(), [](const Fill& a, const Fill& b) { return a.area < b.area; });
  double all = surfaceArea(surface), filled = 0;
  for (const Fill& fill : fills) {
    filled += fill.area;
    all += fill.area;
    if (filled > max_filled_share * all) break;
    surface.triangles.insert(surface.triangles.end(), fill.faces.begin(), fill.faces.end());
    ++report.holes;
    report.hole_edges += fill.edges;
  }
  if (!source.triangle_line.empty()) source.triangle_line.resize(surface.triangles.size(), 0);
  return given;
}

}  // namespace palpate

#include "organs/surface_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <numeric>
#include <sstream>

namespace palpate::organs {
namespace {

/// For each vertex: who follows whom around it, and whether that is one single ring.
bool fansAreRings(const TriangleSurface& surface) {
  std::vector<std::map<int, int>> next(surface.vertices.size());
  for (const auto& t : surface.triangles) {
    for (int s = 0; s < 3; ++s) next[t[s]][t[(s + 1) % 3]] = t[(s + 2) % 3];
  }
  return std::all_of(next.begin(), next.end(), [](const std::map<int, int>& ring) {
    if (ring.empty()) return false;
    std::size_t steps = 0;
    int v = ring.begin()->first;
    do {
      const auto found = ring.find(v);
      if (found == ring.end()) return false;
      v = found->second;
      ++steps;
    } while (v != ring.begin()->first && steps <= ring.size());
    return steps == ring.size();
  });
}

int countComponents(const TriangleSurface& surface) {
  std::vector<int> parent(surface.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [a, b, c] : surface.triangles) {
    parent[root(a)] = root(b);
    parent[root(b)] = root(c);
  }
  int count = 0;
  for (int v = 0; v < static_cast<int>(parent.size()); ++v) count += root(v) == v ? 1 : 0;
  return count;
}

}  // namespace

SurfaceReport reportOn(const TriangleSurface& surface) {
  SurfaceReport report;
  report.vertices = static_cast<int>(surface.vertices.size());
  report.triangles = static_cast<int>(surface.triangles.size());
  report.min = Vec3::Constant(std::numeric_limits<double>::max());
  report.max = -report.min;
  for (const Vec3& x : surface.vertices) {
    report.min = report.min.cwiseMin(x);
    report.max = report.max.cwiseMax(x);
  }

  std::map<std::pair<int, int>, int> uses;  // of each directed edge
  report.shortest_edge = std::numeric_limits<double>::max();
  double largest_cosine = -1;
  double edge_sum = 0;
  for (const auto& t : surface.triangles) {
    const Vec3& a = surface.vertices[t[0]];
    const Vec3& b = surface.vertices[t[1]];
    const Vec3& c = surface.vertices[t[2]];
    report.volume += a.dot(b.cross(c)) / 6;
    report.area += (b - a).cross(c - a).norm() / 2;
    for (int s = 0; s < 3; ++s) {
      ++uses[{t[s], t[(s + 1) % 3]}];
      const Vec3 forward = surface.vertices[t[(s + 1) % 3]] - surface.vertices[t[s]];
      const Vec3 back = surface.vertices[t[(s + 2) % 3]] - surface.vertices[t[s]];
      const double length = forward.norm();
      report.shortest_edge = std::min(report.shortest_edge, length);
      report.longest_edge = std::max(report.longest_edge, length);
      edge_sum += length;
      largest_cosine = std::max(largest_cosine, forward.normalized().dot(back.normalized()));
    }
  }
  report.mean_edge = edge_sum / (3.0 * report.triangles);
  report.smallest_angle_deg = std::acos(std::min(1.0, largest_cosine)) * 180 / M_PI;

  report.closed = std::all_of(uses.begin(), uses.end(), [&uses](const auto& use) {
    const auto twin = uses.find({use.first.second, use.first.first});
    return use.second == 1 && twin != uses.end() && twin->second == 1;
  });
  report.manifold = report.closed && fansAreRings(surface);
  report.components = countComponents(surface);
  const int edges = static_cast<int>(uses.size()) / 2;
  report.genus = report.components - (report.vertices - edges + report.triangles) / 2;
  return report;
}

std::string SurfaceReport::text() const {
  std::ostringstream s;
  const Vec3 size = max - min;
  s << std::fixed << std::setprecision(1) << "  " << triangles << " triangles, " << vertices << " vertices; "
    << (manifold ? "closed manifold"
        : closed ? "closed, NOT manifold"
                 : "NOT closed")
    << ", " << components << (components == 1 ? " piece" : " pieces") << ", genus " << genus << "\n"
    << "  size " << size.x() * 1e3 << " x " << size.y() * 1e3 << " x " << size.z() * 1e3 << " mm, x " << min.x() * 1e3
    << ".." << max.x() * 1e3 << ", y " << min.y() * 1e3 << ".." << max.y() * 1e3 << ", z " << min.z() * 1e3 << ".."
    << max.z() * 1e3 << "\n"
    << "  volume " << volume * 1e6 << " ml, area " << area * 1e4 << " cm2\n"
    << std::setprecision(2) << "  edges " << shortest_edge * 1e3 << " / " << mean_edge * 1e3 << " / "
    << longest_edge * 1e3 << " mm (shortest, mean, longest), smallest angle " << smallest_angle_deg << " degrees\n";
  return s.str();
}

}  // namespace palpate::organs

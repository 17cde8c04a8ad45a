#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "base/parallel_for.h"
#include "base/ranked.h"
#include "discretization/surface/surface_geometry.h"
#include "discretization/surface/surface_parts.h"
#include "discretization/surface/surface_tree.h"
#include "imaging/mend_surface.h"

namespace palpate {
namespace {

using Triangle = std::array<int, 3>;

// As checkSurface has it: a face is flat where its height is below this fraction of its longest edge.
constexpr double flat_face_ratio = 1e-9;

// Rims closer together than this fraction of the surface's size, and of their own edges, were meant to be joined.
constexpr double rim_gap = 1e-3, rim_gap_of_edge = 0.2;
// A vertex hangs in an edge where it is no further from it than this fraction of the surface's size and of the edge.
constexpr double hanging_gap = 2e-5, hanging_gap_of_edge = 0.05;

// Stray vertices are at most so many of all, lie so many times as far from the middle as any other, and leave a hole of
// this share of the area at most.
constexpr double most_stray = 0.01, stray_gap = 3, most_stray_hole = 0.05;

bool isFlat(const TriangleSurface& s, const Triangle& t) {
  const auto& [a, b, c] = t;
  if (a == b || b == c || c == a) return true;
  const Vec3 &A = s.vertices[a], &B = s.vertices[b], &C = s.vertices[c];
  const double longest = std::max({(B - A).squaredNorm(), (C - B).squaredNorm(), (A - C).squaredNorm()});
  return !((B - A).cross(C - A).norm() > 1.5 * flat_face_ratio * longest);
}

int removeFlat(TriangleSurface& surface, SurfaceSource& source) {
  return keepFaces(surface, source, [&](int t) { return !isFlat(surface, surface.triangles[t]); });
}

int removeDoubled(TriangleSurface& surface, SurfaceSource& source) {
  const int count = static_cast<int>(surface.triangles.size());
  std::vector<Triangle> sorted = surface.triangles;
  for (Triangle& t : sorted) std::sort(t.begin(), t.end());
  std::vector<int> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int s, int t) { return sorted[s] != sorted[t] ? sorted[s] < sorted[t] : s < t; });
  std::vector<char> doubled(count, 0);
  for (int i = 1; i < count; ++i) doubled[order[i]] = sorted[order[i]] == sorted[order[i - 1]];
  return keepFaces(surface, source, [&](int t) { return !doubled[t]; });
}

/// The edges that one face has.
std::vector<FaceEdge> openEdges(const TriangleSurface& surface) {
  std::vector<FaceEdge> open;
  forEachEdge(faceEdges(surface), [&](const FaceEdge* edge, int count) {
    if (count == 1) open.push_back(*edge);
  });
  return open;
}

/// The vertices of open edges, to be found near a place.
class RimVertices {
 public:
  RimVertices(const TriangleSurface& surface, const std::vector<FaceEdge>& open) {
    for (const FaceEdge& e : open) {
      vertex.push_back(e.low);
      vertex.push_back(e.high);
    }
    std::sort(vertex.begin(), vertex.end());
    vertex.erase(std::unique(vertex.begin(), vertex.end()), vertex.end());
    TriangleSurface points;
    for (int i = 0; i < static_cast<int>(vertex.size()); ++i) {
      points.vertices.push_back(surface.vertices[vertex[i]]);
      points.triangles.push_back({i, i, i});
    }
    tree_.emplace(std::move(points));
  }

  /// Indices into `vertex`, ascending.
  void near(const Box3& box, std::vector<int>& found) const {
    found.clear();
    tree_->facesNear(box, found);
    std::sort(found.begin(), found.end());
  }

  std::vector<int> vertex;  // (rim vertex count), ascending

 private:
  std::optional<SurfaceTree> tree_;
};

/// Joins vertices of different rims that nearly touch. Returns how many went.
int joinRims(TriangleSurface& surface, double size) {
  const std::vector<FaceEdge> open = openEdges(surface);
  if (open.empty()) return 0;
  const RimVertices rim(surface, open);
  std::vector<double> reach(rim.vertex.size(), rim_gap * size);
  const auto place = [&](int v) {
    return static_cast<std::size_t>(std::lower_bound(rim.vertex.begin(), rim.vertex.end(), v) - rim.vertex.begin());
  };
  for (const FaceEdge& e : open) {
    const double length = rim_gap_of_edge * (surface.vertices[e.low] - surface.vertices[e.high]).norm();
    for (const int v : {e.low, e.high}) reach[place(v)] = std::min(reach[place(v)], length);
  }
  std::vector<int> joined(surface.vertices.size());
  std::iota(joined.begin(), joined.end(), 0);
  std::vector<int> near;
  int count = 0;
  for (std::size_t i = 0; i < rim.vertex.size(); ++i) {
    const int v = rim.vertex[i];
    if (joined[v] != v) continue;
    const Vec3 x = surface.vertices[v], r = Vec3::Constant(reach[i]);
    rim.near(Box3(x - r, x + r), near);
    for (const int k : near) {
      const int w = rim.vertex[k];
      if (w <= v || joined[w] != w) continue;
      if ((surface.vertices[w] - x).norm() > std::min(reach[i], reach[static_cast<std::size_t>(k)])) continue;
      joined[w] = v;
      ++count;
    }
  }
  if (count == 0) return 0;
  for (Triangle& t : surface.triangles)
    for (int& v : t) v = joined[v];
  return count;
}

/// Splits faces at vertices that hang in their open edges. Returns how many it split.
int splitAtHanging(TriangleSurface& surface, SurfaceSource& source, double size) {
  const std::vector<FaceEdge> open = openEdges(surface);
  if (open.empty()) return 0;
  const RimVertices rim(surface, open);
  // Of each face the vertices on its edges 0 1, 1 2 and 2 0, from one end to the other.
  std::map<int, std::array<std::vector<int>, 3>> hanging;
  std::vector<int> near;
  for (const FaceEdge& e : open) {
    SetupWatch::check();
    const Triangle& t = surface.triangles[e.triangle];
    const int from = e.forward ? e.low : e.high, to = e.forward ? e.high : e.low;
    const int side = t[0] == from ? 0 : t[1] == from ? 1 : 2;
    const Vec3 a = surface.vertices[from], ab = surface.vertices[to] - a;
    const double length = ab.norm(), gap = std::min(hanging_gap * size, hanging_gap_of_edge * length);
    Box3 box(a);
    box.extend(surface.vertices[to]);
    rim.near(Box3(box.min() - Vec3::Constant(gap), box.max() + Vec3::Constant(gap)), near);
    std::vector<std::pair<double, int>> on;
    for (const int k : near) {
      const int v = rim.vertex[k];
      if (v == t[0] || v == t[1] || v == t[2]) continue;
      const double along = (surface.vertices[v] - a).dot(ab) / (length * length);
      if (along * length <= gap || (1 - along) * length <= gap) continue;
      if ((surface.vertices[v] - a - along * ab).norm() <= gap) on.emplace_back(along, v);
    }
    std::sort(on.begin(), on.end());
    for (const auto& [along, v] : on) hanging[e.triangle][side].push_back(v);
  }
  for (const auto& [t, sides] : hanging) {
    const Triangle corner = surface.triangles[t];
    std::vector<Triangle> pieces = {corner};
    for (int side = 0; side < 3; ++side) {
      for (const int v : sides[side]) {
        // The piece with the rest of this edge: from what was split off last to the edge's end.
        const int to = corner[(side + 1) % 3];
        const std::size_t at = [&, &sides = sides] {
          for (std::size_t p = 0; p < pieces.size(); ++p)
            for (int s = 0; s < 3; ++s)
              if (pieces[p][(s + 1) % 3] == to &&
                  (pieces[p][s] == corner[side] ||
                   std::find(sides[side].begin(), sides[side].end(), pieces[p][s]) != sides[side].end()))
                return p;
          return pieces.size();
        }();
        if (at == pieces.size()) continue;
        Triangle& piece = pieces[at];
        const int s = piece[1] == to ? 0 : piece[2] == to ? 1 : 2;
        const Triangle rest = {v, to, piece[(s + 2) % 3]};
        piece = {piece[s], v, piece[(s + 2) % 3]};
        pieces.push_back(rest);
      }
    }
    surface.triangles[t] = pieces[0];
    for (std::size_t p = 1; p < pieces.size(); ++p) {
      surface.triangles.push_back(pieces[p]);
      if (!source.triangle_line.empty()) source.triangle_line.push_back(source.triangle_line[t]);
    }
  }
  return static_cast<int>(hanging.size());
}

}  // namespace

void dropStray(TriangleSurface& surface, SurfaceSource& source, RepairReport& report) {
  const std::size_t count = surface.vertices.size();
  const std::size_t most = std::max<std::size_t>(3, static_cast<std::size_t>(most_stray * static_cast<double>(count)));
  if (count < most + 4) return;
  Vec3 middle;
  std::vector<double> along(count);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t v = 0; v < count; ++v) along[v] = surface.vertices[v][axis];
    middle[axis] = ranked(along, count / 2);
  }
  for (std::size_t v = 0; v < count; ++v) along[v] = (surface.vertices[v] - middle).norm();
  std::vector<double> off = along;
  std::sort(off.begin(), off.end());
  std::size_t first = count - most;
  while (first < count && off[first] <= stray_gap * off[first - 1]) ++first;
  if (first == count || !(off[first - 1] > 0)) return;
  const auto isStray = [&](int v) { return along[static_cast<std::size_t>(v)] >= off[first]; };
  // What their faces leave open is no larger than a circle with the rim's length.
  std::map<int, double> rim;  // by a face's first stray vertex
  double rest = 0;            // area
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const Triangle& corner = surface.triangles[t];
    const auto stray = std::find_if(corner.begin(), corner.end(), isStray);
    if (stray == corner.end()) rest += areaVector(surface, t).norm();
    for (int k = 0; k < 3 && stray != corner.end(); ++k)
      if (!isStray(corner[k]) && !isStray(corner[(k + 1) % 3]))
        rim[*stray] += (surface.vertices[corner[k]] - surface.vertices[corner[(k + 1) % 3]]).norm();
  }
  double open = 0;
  for (const auto& [v, length] : rim) open += length * length / (4 * std::numbers::pi);
  if (open > most_stray_hole * rest) return;
  report.stray_vertices = static_cast<int>(count - first);
  report.stray_sizes = off.back() / (2 * off[first - 1]);
  report.stray_faces = keepFaces(surface, source, [&](int t) {
    return std::none_of(surface.triangles[t].begin(), surface.triangles[t].end(), isStray);
  });
  dropUnusedVertices(surface, source);
}

void tidyFaces(TriangleSurface& surface, SurfaceSource& source, RepairReport& report) {
  const double size = boundingBox(surface).diagonal().norm();
  report.flat_faces += removeFlat(surface, source);
  report.doubled_faces += removeDoubled(surface, source);
  if (const int joined = joinRims(surface, size); joined > 0) {
    report.joined_vertices += joined;
    report.flat_faces += removeFlat(surface, source);
    report.doubled_faces += removeDoubled(surface, source);
  }
  constexpr int max_rounds = 4;  // a split may leave another vertex hanging
  for (int round = 0; round < max_rounds; ++round) {
    const int split = splitAtHanging(surface, source, size);
    report.split_faces += split;
    if (split == 0) break;
    report.flat_faces += removeFlat(surface, source);
    report.doubled_faces += removeDoubled(surface, source);
  }
  dropUnusedVertices(surface, source);
}

}  // namespace palpate

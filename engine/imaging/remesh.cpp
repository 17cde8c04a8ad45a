#include "imaging/remesh.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace palpate {
namespace {

using Triangle = std::array<int, 3>;

/// A closed triangulation under change. Each vertex knows its fan, the triangles around it.
class Remesher {
 public:
  Remesher(const TriangleSurface& surface, const Field& field, double edge_length)
      : field_(field), target_(edge_length), x_(surface.vertices), triangles_(surface.triangles), fan_(x_.size()) {
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
      for (const int v : triangles_[t]) fan_[v].push_back(t);
    }
    for (Vec3& x : x_) x = projected(x);
  }

  void splitLongEdges() {
    const double longest = 4.0 / 3.0 * target_;
    for (const auto& [a, b] : edges()) {
      if ((x_[a] - x_[b]).norm() > longest) split(a, b);
    }
  }

  void collapseShortEdges() {
    const double shortest = 4.0 / 5.0 * target_;
    for (const auto& [a, b] : edges()) {
      if (isEdge(a, b) && (x_[a] - x_[b]).norm() < shortest) collapse(a, b);
    }
  }

  /// Flips where that brings the four vertices nearer to six neighbours each.
  void flipForValence() {
    for (const auto& [a, b] : edges()) {
      if (!isEdge(a, b)) continue;
      const auto [c, d] = opposite(a, b);
      const auto excess = [this](int v, int change) {
        const int e = static_cast<int>(fan_[v].size()) + change - 6;
        return e * e;
      };
      const int now = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
      const int then = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
      if (then < now) flip(a, b);
    }
  }

  /// Flips where the two angles opposite the edge sum to more than pi (Delaunay).
  void flipForAngles() {
    for (const auto& [a, b] : edges()) {
      if (!isEdge(a, b)) continue;
      const auto [c, d] = opposite(a, b);
      constexpr double kTie = 1e-6;  // leave squares alone, or they flip for ever
      if (cosineAt(c, a, b) + cosineAt(d, a, b) < -kTie) flip(a, b);
    }
  }

  /// Moves each vertex along the surface to the area-weighted centre of its fan.
  void relax() {
    std::vector<Vec3> moved = x_;
    for (std::size_t v = 0; v < x_.size(); ++v) {
      if (fan_[v].empty()) continue;
      Vec3 centre = Vec3::Zero();
      double area = 0;
      for (const int t : fan_[v]) {
        const auto& [i, j, k] = triangles_[t];
        const double twice_area = (x_[j] - x_[i]).cross(x_[k] - x_[i]).norm();
        centre += twice_area * (x_[i] + x_[j] + x_[k]) / 3;
        area += twice_area;
      }
      const Vec3 n = gradient(x_[v]).normalized();
      const Vec3 step = centre / area - x_[v];
      moved[v] = projected(x_[v] + step - n * n.dot(step));
    }
    x_ = std::move(moved);
  }

  /// What is left, numbered from 0 without gaps.
  TriangleSurface take() const {
    TriangleSurface surface;
    std::vector<int> number(x_.size(), -1);
    for (std::size_t v = 0; v < x_.size(); ++v) {
      if (fan_[v].empty()) continue;
      number[v] = static_cast<int>(surface.vertices.size());
      surface.vertices.push_back(x_[v]);
    }
    for (const Triangle& t : triangles_) {
      if (isAlive(t)) surface.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
    }
    return surface;
  }

 private:
  static bool isAlive(const Triangle& t) { return t[0] >= 0; }
  static bool contains(const Triangle& t, int v) { return t[0] == v || t[1] == v || t[2] == v; }

  Vec3 gradient(const Vec3& p) const {
    const double h = 0.02 * target_;
    Vec3 g;
    for (int a = 0; a < 3; ++a) {
      const Vec3 step = h * Vec3::Unit(a);
      g[a] = (field_(p + step) - field_(p - step)) / (2 * h);
    }
    return g;
  }

  /// The nearby point where the field vanishes, by Newton steps along its gradient. A step
  /// is at most half an edge long, so that a flat spot of the field throws nothing far away.
  Vec3 projected(Vec3 p) const {
    constexpr int kSteps = 6;
    constexpr double kOnSurface = 1e-7;  // m; the file's own precision is no better
    for (int i = 0; i < kSteps; ++i) {
      const double f = field_(p);
      if (std::abs(f) < kOnSurface) break;
      const Vec3 g = gradient(p);
      const Vec3 step = g * (f / g.squaredNorm());
      p -= step * std::min(1.0, 0.5 * target_ / step.norm());
    }
    return p;
  }

  /// All edges as they are now, each once, in a fixed order.
  std::vector<std::pair<int, int>> edges() const {
    std::vector<std::pair<int, int>> list;
    for (const Triangle& t : triangles_) {
      for (int s = 0; s < 3 && isAlive(t); ++s) {
        const int a = t[s];
        const int b = t[(s + 1) % 3];
        if (a < b) list.emplace_back(a, b);  // its other triangle runs from b to a
      }
    }
    return list;
  }

  bool isEdge(int a, int b) const {
    return std::any_of(fan_[a].begin(), fan_[a].end(), [&](int t) { return contains(triangles_[t], b); });
  }

  /// The two triangles on edge ab: the one that runs from a to b, then the other.
  std::pair<int, int> wings(int a, int b) const {
    std::pair<int, int> found{-1, -1};
    for (const int t : fan_[a]) {
      for (int s = 0; s < 3; ++s) {
        if (triangles_[t][s] != a) continue;
        if (triangles_[t][(s + 1) % 3] == b) found.first = t;
        if (triangles_[t][(s + 2) % 3] == b) found.second = t;
      }
    }
    return found;
  }

  int third(int t, int a, int b) const { return triangles_[t][0] + triangles_[t][1] + triangles_[t][2] - a - b; }

  std::pair<int, int> opposite(int a, int b) const {
    const auto [left, right] = wings(a, b);
    return {third(left, a, b), third(right, a, b)};
  }

  double cosineAt(int corner, int a, int b) const {
    return (x_[a] - x_[corner]).normalized().dot((x_[b] - x_[corner]).normalized());
  }

  /// True if the triangle is not degenerate and faces within 60 degrees of the surface's normal.
  bool facesOutward(const Vec3& a, const Vec3& b, const Vec3& c) const {
    const Vec3 n = (b - a).cross(c - a);
    return n.dot(gradient((a + b + c) / 3).normalized()) > 0.5 * n.norm() && n.norm() > 1e-6 * target_ * target_;
  }

  void replaceVertex(int t, int from, int to) {
    for (int& v : triangles_[t]) {
      if (v == from) v = to;
    }
  }
  void leaveFan(int v, int t) { fan_[v].erase(std::find(fan_[v].begin(), fan_[v].end(), t)); }

  void split(int a, int b) {
    const int m = static_cast<int>(x_.size());
    x_.push_back(projected(0.5 * (x_[a] + x_[b])));
    fan_.emplace_back();
    const auto [left, right] = wings(a, b);
    for (const int t : {left, right}) {
      // Triangle t keeps a and gets m for b; a new one has b and m.
      const int c = third(t, a, b);
      const int added = static_cast<int>(triangles_.size());
      triangles_.push_back(triangles_[t]);
      replaceVertex(t, b, m);
      replaceVertex(added, a, m);
      leaveFan(b, t);
      fan_[b].push_back(added);
      fan_[c].push_back(added);
      fan_[m].push_back(t);
      fan_[m].push_back(added);
    }
  }

  /// Merges b into a at their middle, unless that changed the topology, turned a
  /// triangle over or made an edge that the next pass would split again.
  void collapse(int a, int b) {
    const auto [left, right] = wings(a, b);
    const int c = third(left, a, b);
    const int d = third(right, a, b);
    if (fan_[c].size() <= 3 || fan_[d].size() <= 3) return;
    // On a closed manifold ab may go if c and d are the only neighbours that a and b share.
    for (const int t : fan_[a]) {
      for (const int v : triangles_[t]) {
        if (v != a && v != b && v != c && v != d && isEdge(v, b)) return;
      }
    }
    const Vec3 middle = projected(0.5 * (x_[a] + x_[b]));
    for (const int end : {a, b}) {
      for (const int t : fan_[end]) {
        if (t == left || t == right) continue;
        std::array<Vec3, 3> corner;
        for (int s = 0; s < 3; ++s) {
          const int v = triangles_[t][s];
          corner[s] = v == end ? middle : x_[v];
          if ((corner[s] - middle).norm() > 4.0 / 3.0 * target_) return;
        }
        if (!facesOutward(corner[0], corner[1], corner[2])) return;
      }
    }

    x_[a] = middle;
    for (const int t : {left, right}) {
      for (const int v : triangles_[t]) leaveFan(v, t);
      triangles_[t] = {-1, -1, -1};
    }
    for (const int t : fan_[b]) {
      replaceVertex(t, b, a);
      fan_[a].push_back(t);
    }
    fan_[b].clear();
  }

  /// Replaces edge ab by cd, unless cd exists or a new triangle would face inward.
  void flip(int a, int b) {
    const auto [left, right] = wings(a, b);  // abc and bad
    const int c = third(left, a, b);
    const int d = third(right, a, b);
    if (fan_[a].size() <= 3 || fan_[b].size() <= 3 || isEdge(c, d)) return;
    if (!facesOutward(x_[a], x_[d], x_[c]) || !facesOutward(x_[d], x_[b], x_[c])) return;
    triangles_[left] = {a, d, c};
    triangles_[right] = {d, b, c};
    leaveFan(b, left);
    leaveFan(a, right);
    fan_[d].push_back(left);
    fan_[c].push_back(right);
  }

  const Field& field_;
  double target_;
  std::vector<Vec3> x_;
  std::vector<Triangle> triangles_;    // {-1, -1, -1} once collapsed away
  std::vector<std::vector<int>> fan_;  // empty once merged away
};

}  // namespace

TriangleSurface remesh(const TriangleSurface& surface, const Field& field, double edge_length) {
  Remesher mesh(surface, field, edge_length);
  constexpr int kShapingPasses = 10;   // edge lengths settle after about six
  constexpr int kPolishingPasses = 6;  // angles only; the vertices stay
  for (int pass = 0; pass < kShapingPasses; ++pass) {
    mesh.splitLongEdges();
    mesh.collapseShortEdges();
    mesh.flipForValence();
    mesh.relax();
  }
  for (int pass = 0; pass < kPolishingPasses; ++pass) {
    mesh.flipForAngles();
    mesh.relax();
  }
  mesh.flipForAngles();
  return mesh.take();
}

}  // namespace palpate

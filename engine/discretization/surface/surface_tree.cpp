#include "discretization/surface/surface_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "base/parallel_for.h"

namespace palpate {

namespace {

constexpr int leaf_size = 4;

// A group of faces is taken for a dipole from this many of its radii away. The error falls
// with its square: 2.0 leaves about 0.01 of a winding number, 3.0 half of that at twice the cost.
constexpr double far_factor = 2.3;

// Depth of a median-split tree over at most 2^31 faces, with room to spare.
constexpr int max_depth = 64;

struct Stack {
  std::array<int, max_depth> entries;
  int size = 0;
  void push(int i) { entries[size++] = i; }
  int pop() { return entries[--size]; }
};

// Solid angle of triangle abc (relative to the observer), over 4 pi. Van Oosterom and Strackee 1983.
double solidAngleFraction(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double volume = a.dot(b.cross(c));
  const double cosine = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(volume, cosine) / (2.0 * std::numbers::pi);
}

double cross(const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p.x() * q.y() - p.y() * q.x(); }

// The sign of cross(p, q), or 0 where rounding hides it: never the wrong sign, since rounding keeps the order
// of the products. (Their difference, contracted to a fused multiply-add, would not.) So the two
// faces of an edge never both turn the ray away, and none slips between them.
int turn(const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
  const double left = p.x() * q.y(), right = p.y() * q.x();
  return left > right ? 1 : left < right ? -1 : 0;
}

}  // namespace

SurfaceTree::SurfaceTree(TriangleSurface surface) : surface_(std::move(surface)) {
  const int count = static_cast<int>(surface_.triangles.size());
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> centroids(count);
  for (int t = 0; t < count; ++t) {
    const auto& [a, b, c] = surface_.triangles[t];
    centroids[t] = (surface_.vertices[a] + surface_.vertices[b] + surface_.vertices[c]) / 3.0;
  }
  nodes_.reserve(count > 0 ? 2 * static_cast<std::size_t>(count) : 0);
  if (count > 0) build(0, count, centroids);
}

/// Large parts on cores of their own, whose nodes are put together afterwards: the same tree on any number of cores.
int SurfaceTree::build(int begin, int end, std::vector<Vec3>& centroids) {
  constexpr int worth_a_core = 100'000;  // faces
  // Of the faces order_[first .. last); where they are many, they are parted in the middle.
  const auto nodeOf = [&](int first, int last) {
    Node node;
    Box3 centroid_box;
    double area = 0;
    for (int i = first; i < last; ++i) {
      const int t = order_[i];
      node.box.extend(faceBox(surface_, t));
      centroid_box.extend(centroids[t]);
      const Vec3 vector = areaVector(surface_, t);
      node.area_vector += vector;
      node.centre += vector.norm() * centroids[t];
      area += vector.norm();
    }
    node.centre = area > 0 ? Vec3(node.centre / area) : node.box.center();
    for (int i = first; i < last; ++i)
      for (int v : surface_.triangles[order_[i]])
        node.radius = std::max(node.radius, (surface_.vertices[v] - node.centre).norm());
    if (last - first <= leaf_size) {
      node.first = first;
      node.count = last - first;
      return node;
    }
    int axis = 0;
    centroid_box.sizes().maxCoeff(&axis);
    std::nth_element(order_.begin() + first, order_.begin() + first + (last - first) / 2, order_.begin() + last,
                     [&](int s, int t) {
                       // Ties by index: the tree is the same on every run.
                       return std::pair(centroids[s][axis], s) < std::pair(centroids[t][axis], t);
                     });
    return node;
  };
  const auto add = [&](const auto& self, int first, int last, std::vector<Node>& nodes) -> int {
    const auto index = nodes.size();
    nodes.emplace_back();
    Node node = nodeOf(first, last);
    if (node.count == 0) {
      const int middle = first + (last - first) / 2;
      if (last - first > worth_a_core) {
        std::vector<Node> half[2];
        parallelFor(
            2,
            [&](int from, int to) {
              for (int h = from; h < to; ++h) self(self, h == 0 ? first : middle, h == 0 ? middle : last, half[h]);
            },
            1);
        for (int h = 0; h < 2; ++h) {
          const int offset = static_cast<int>(nodes.size());
          if (h == 1) node.first = offset;
          for (Node& n : half[h]) {
            if (n.count == 0) n.first += offset;
            nodes.push_back(n);
          }
          half[h] = {};
        }
      } else {
        self(self, first, middle, nodes);
        node.first = self(self, middle, last, nodes);
      }
    }
    nodes[index] = node;
    return static_cast<int>(index);
  };
  return add(add, begin, end, nodes_);
}

double SurfaceTree::windingNumber(const Vec3& x) const {
  if (nodes_.empty()) return 0;
  double winding = 0;
  Stack stack;
  stack.push(0);
  while (stack.size > 0) {
    const int index = stack.pop();
    const Node& node = nodes_[index];
    const Vec3 offset = node.centre - x;
    const double distance_squared = offset.squaredNorm();
    const double near = far_factor * node.radius;
    if (distance_squared > near * near) {
      winding +=
          node.area_vector.dot(offset) / (4.0 * std::numbers::pi * distance_squared * std::sqrt(distance_squared));
    } else if (node.count > 0) {
      for (int i = node.first; i < node.first + node.count; ++i) {
        const auto& [a, b, c] = surface_.triangles[order_[i]];
        winding += solidAngleFraction(surface_.vertices[a] - x, surface_.vertices[b] - x, surface_.vertices[c] - x);
      }
    } else {
      stack.push(node.first);
      stack.push(index + 1);
    }
  }
  return winding;
}

SurfaceTree::Closest SurfaceTree::closest(const Vec3& x, double max_distance) const {
  Closest best;
  if (nodes_.empty()) return best;
  double best_squared = max_distance * max_distance;
  Stack stack;
  stack.push(0);
  while (stack.size > 0) {
    const int index = stack.pop();
    const Node& node = nodes_[index];
    if (node.box.squaredExteriorDistance(x) > best_squared) continue;
    if (node.count > 0) {
      for (int i = node.first; i < node.first + node.count; ++i) {
        const int t = order_[i];
        const auto& [a, b, c] = surface_.triangles[t];
        const Vec3 &A = surface_.vertices[a], &B = surface_.vertices[b], &C = surface_.vertices[c];
        const Vec3 weights = closestBarycentric(x, A, B, C);
        const Vec3 point = weights[0] * A + weights[1] * B + weights[2] * C;
        const double squared = (point - x).squaredNorm();
        // Ties (shared edges) go to the lower face, whatever the tree's order.
        if (squared < best_squared || (squared == best_squared && (best.triangle < 0 || t < best.triangle))) {
          best_squared = squared;
          best = {t, point, weights, std::sqrt(squared)};
        }
      }
    } else {
      const int left = index + 1, right = node.first;
      const bool left_first =
          nodes_[left].box.squaredExteriorDistance(x) <= nodes_[right].box.squaredExteriorDistance(x);
      stack.push(left_first ? right : left);
      stack.push(left_first ? left : right);
    }
  }
  return best;
}

double SurfaceTree::signedDistance(const Vec3& x) const {
  const Closest foot = closest(x);
  // Where the foot is well within its face, the face's side decides, as the solid angles would.
  constexpr double within = 1e-6;
  const Vec3 normal = foot.triangle >= 0 ? areaVector(surface_, foot.triangle) : Vec3::Zero();
  const double side = normal.dot(x - foot.point);
  const bool clear = foot.barycentric.minCoeff() > within && std::abs(side) > 0.5 * normal.norm() * foot.distance;
  return (clear ? side < 0 : inside(x)) ? -foot.distance : foot.distance;
}

std::optional<SurfaceTree::Hit> SurfaceTree::firstHit(const Vec3& origin, const Vec3& direction,
                                                      double max_distance) const {
  const double length = direction.norm();
  if (nodes_.empty() || !(length > 0)) return std::nullopt;
  const Vec3 d = direction / length;

  // Where the ray enters a box; infinity where it misses. A margin of rounding keeps flat boxes hittable.
  const auto entry = [&](const Box3& box, double limit) {
    double enter = 0, leave = limit;
    for (int k = 0; k < 3; ++k) {
      const double margin = 1e-12 * (std::abs(origin[k]) + std::abs(box.min()[k]) + std::abs(box.max()[k]));
      const double low = box.min()[k] - margin - origin[k], high = box.max()[k] + margin - origin[k];
      if (d[k] == 0) {
        if (low > 0 || high < 0) return std::numeric_limits<double>::infinity();
      } else {
        enter = std::max(enter, std::min(low / d[k], high / d[k]));
        leave = std::min(leave, std::max(low / d[k], high / d[k]));
      }
    }
    return enter <= leave * (1 + 1e-12) ? enter : std::numeric_limits<double>::infinity();
  };

  // A shear takes the ray onto an axis (Woop, Benthin and Wald 2013): whether it passes a triangle is then
  // a question about plane points around the origin.
  int along = 0;
  d.cwiseAbs().maxCoeff(&along);
  const int across_x = (along + 1) % 3, across_y = (along + 2) % 3;
  const double shear_x = d[across_x] / d[along], shear_y = d[across_y] / d[along];
  const auto flattened = [&](int v) {
    const Vec3 p = surface_.vertices[v] - origin;
    return Eigen::Vector2d(p[across_x] - shear_x * p[along], p[across_y] - shear_y * p[along]);
  };

  std::optional<Hit> best;
  double limit = max_distance;
  Stack stack;
  stack.push(0);
  while (stack.size > 0) {
    const int index = stack.pop();
    const Node& node = nodes_[index];
    if (entry(node.box, limit) == std::numeric_limits<double>::infinity()) continue;
    if (node.count == 0) {
      const int left = index + 1, right = node.first;
      const bool left_first = entry(nodes_[left].box, limit) <= entry(nodes_[right].box, limit);
      stack.push(left_first ? right : left);
      stack.push(left_first ? left : right);
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int t = order_[i];
      const auto& [a, b, c] = surface_.triangles[t];
      const Eigen::Vector2d p = flattened(a), q = flattened(b), r = flattened(c);
      const int sa = turn(q, r), sb = turn(r, p), sc = turn(p, q);
      const bool through = (sa >= 0 && sb >= 0 && sc >= 0) || (sa <= 0 && sb <= 0 && sc <= 0);
      const double wa = sa * std::abs(cross(q, r)), wb = sb * std::abs(cross(r, p)), wc = sc * std::abs(cross(p, q));
      const double sum = wa + wb + wc;
      if (!through || sum == 0) continue;  // sum 0: the ray lies in the face's plane; its neighbours are hit
      const Vec3 point = (wa * surface_.vertices[a] + wb * surface_.vertices[b] + wc * surface_.vertices[c]) / sum;
      const double distance = (point - origin).dot(d);
      if (distance < 0 || distance > limit) continue;
      if (best && distance == limit && t > best->triangle) continue;
      limit = distance;
      best = Hit{t, point, distance};
    }
  }
  return best;
}

void SurfaceTree::facesNear(const Box3& box, std::vector<int>& triangles) const {
  if (nodes_.empty()) return;
  Stack stack;
  stack.push(0);
  while (stack.size > 0) {
    const int index = stack.pop();
    const Node& node = nodes_[index];
    if (!node.box.intersects(box)) continue;
    if (node.count > 0) {
      for (int i = node.first; i < node.first + node.count; ++i) {
        if (faceBox(surface_, order_[i]).intersects(box)) triangles.push_back(order_[i]);
      }
    } else {
      stack.push(node.first);
      stack.push(index + 1);
    }
  }
}

}  // namespace palpate

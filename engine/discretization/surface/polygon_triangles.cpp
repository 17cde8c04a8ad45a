#include "discretization/surface/polygon_triangles.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numeric>

namespace palpate {
namespace {

using Vec2 = Eigen::Vector2d;

// Of its longest edge squared: a triangle of less than that is avoided.
constexpr double flat_ratio = 1e-6;

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/// The corners as seen against the polygon's normal (Newell's sum): it runs counter-clockwise.
std::vector<Vec2> flattened(std::span<const Vec3> corners) {
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i)
    normal += (corners[i] - corners[0]).cross(corners[(i + 1) % corners.size()] - corners[0]);
  if (!(normal.norm() > 0)) normal = Vec3::UnitZ();
  normal.normalize();
  const Vec3 e1 = normal.unitOrthogonal(), e2 = normal.cross(e1);
  std::vector<Vec2> flat;
  flat.reserve(corners.size());
  for (const Vec3& x : corners) flat.emplace_back((x - corners[0]).dot(e1), (x - corners[0]).dot(e2));
  return flat;
}

/// A ring of corners of which ears are cut off.
class Ears {
 public:
  Ears(std::vector<Vec2> x, CutBudget& budget)
      : x_(std::move(x)), next_(x_.size()), before_(x_.size()), budget_(budget) {
    const int n = static_cast<int>(x_.size());
    for (int i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      before_[i] = (i + n - 1) % n;
    }
  }

  std::vector<std::array<int, 3>> cut() {
    std::vector<std::array<int, 3>> triangles;
    int left = static_cast<int>(x_.size()), at = 0, passed = 0;
    while (left > 3) {
      // A corner on a straight line is cut only where nothing else is left.
      const bool anything = passed > 2 * left || budget_.visits <= 0;
      if (anything || isEar(at, passed > left)) {
        triangles.push_back({before_[at], at, next_[at]});
        next_[before_[at]] = next_[at];
        before_[next_[at]] = before_[at];
        --left;
        passed = 0;
      } else {
        ++passed;
      }
      at = next_[at];
    }
    triangles.push_back({before_[at], at, next_[at]});
    return triangles;
  }

 private:
  bool isEar(int i, bool flat_too) {
    const Vec2 &a = x_[before_[i]], &b = x_[i], &c = x_[next_[i]];
    const double area = turn(a, b, c);
    if (!(area > 0) && !(flat_too && area == 0)) return false;
    for (int k = next_[next_[i]]; k != before_[i]; k = next_[k]) {
      --budget_.visits;
      const Vec2& p = x_[k];
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  std::vector<Vec2> x_;
  std::vector<int> next_, before_;
  CutBudget& budget_;
};

}  // namespace

std::vector<std::array<int, 3>> polygonTriangles(std::span<const Vec3> corners, CutBudget& budget) {
  const int n = static_cast<int>(corners.size());
  if (n < 3) return {};
  if (n > 3 && budget.visits > 0) return Ears(flattened(corners), budget).cut();
  std::vector<std::array<int, 3>> fan;
  for (int i = 1; i + 1 < n; ++i) fan.push_back({0, i, i + 1});
  return fan;
}

std::vector<std::array<int, 3>> smallestFill(std::span<const Vec3> corners) {
  const int n = static_cast<int>(corners.size());
  if (n < 3) return {};
  // least(i, k): area that fills the corners i .. k, which corner `apex` between them makes least.
  std::vector<double> least(static_cast<std::size_t>(n) * n, 0.0);
  std::vector<int> apex(static_cast<std::size_t>(n) * n, -1);
  for (int length = 2; length < n; ++length) {
    for (int i = 0; i + length < n; ++i) {
      const int k = i + length;
      double best = std::numeric_limits<double>::infinity();
      for (int m = i + 1; m < k; ++m) {
        const Vec3 a = corners[m] - corners[i], b = corners[k] - corners[i];
        const double own = a.cross(b).norm();
        const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
        // A triangle without area costs as much as a fat one.
        const double area = least[i * n + m] + least[m * n + k] + (own > flat_ratio * longest ? own : longest);
        if (area < best) {
          best = area;
          apex[i * n + k] = m;
        }
      }
      least[i * n + k] = best;
    }
  }
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> open = {{0, n - 1}};
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    const int m = apex[i * n + k];
    if (m < 0) continue;
    triangles.push_back({i, m, k});
    open.push_back({i, m});
    open.push_back({m, k});
  }
  return triangles;
}

}  // namespace palpate

#include "setup/sheet.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/ranked.h"

namespace palpate {
namespace {

using Vec2 = Eigen::Vector2d;

/// The plane through points that fits them best.
struct Plane {
  Vec3 middle = Vec3::Zero(), along = Vec3::UnitX(), across = Vec3::UnitY(), normal = Vec3::UnitZ();
  double length = 0, width = 0;  // m, standard deviations along and across

  explicit Plane(const std::vector<Vec3>& X) {
    const auto n = static_cast<Eigen::Index>(X.size());
    for (const Vec3& x : X) middle += x / static_cast<double>(n);
    Eigen::Matrix3Xd arm(3, n);
    for (Eigen::Index k = 0; k < n; ++k) arm.col(k) = X[static_cast<std::size_t>(k)] - middle;
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(Mat3(arm * arm.transpose()), Eigen::ComputeFullU);
    along = svd.matrixU().col(0);
    across = svd.matrixU().col(1);
    normal = along.cross(across);
    length = std::sqrt(svd.singularValues()[0] / static_cast<double>(n));
    width = std::sqrt(svd.singularValues()[1] / static_cast<double>(n));
  }
  Vec2 at(const Vec3& X) const { return {(X - middle).dot(along), (X - middle).dot(across)}; }
};

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Convex hull, counter-clockwise (Andrew 1979).
std::vector<Vec2> hullOf(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Vec2> hull;
  const auto half = [&](auto begin, auto end) {
    const std::size_t first = hull.size();
    for (auto p = begin; p != end; ++p) {
      while (hull.size() > first + 1 && cross(hull.back() - hull[hull.size() - 2], *p - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(*p);
    }
    hull.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return hull;
}

/// Whether x lies in the hull or no further than `margin` from it.
bool isOver(const std::vector<Vec2>& hull, const Vec2& x, double margin) {
  bool inside = true;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Vec2 &a = hull[k], side = hull[(k + 1) % hull.size()] - a;
    if (cross(side, x - a) >= 0) continue;
    inside = false;
    const double share = std::clamp((x - a).dot(side) / side.squaredNorm(), 0.0, 1.0);
    if ((x - a - share * side).norm() <= margin) return true;
  }
  return inside;
}

/// Median distance of the points to the nearest other.
double distanceOf(const std::vector<Vec3>& X) {
  std::vector<double> nearest(X.size(), std::numeric_limits<double>::infinity());
  for (std::size_t a = 0; a < X.size(); ++a)
    for (std::size_t b = 0; b < X.size(); ++b)
      if (a != b) nearest[a] = std::min(nearest[a], (X[a] - X[b]).norm());
  return ranked(nearest, nearest.size() / 2);
}

/// The spline through the points; lengths in units of `scale`.
class ThinPlate {
 public:
  ThinPlate(const MovedPoints& points, const Vec3& middle, double scale)
      : X_(points.X), middle_(middle), scale_(scale) {
    const auto n = static_cast<Eigen::Index>(X_.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n + 4, n + 4);
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + 4, 3);
    for (Eigen::Index k = 0; k < n; ++k) {
      A.row(k) = terms(X_[static_cast<std::size_t>(k)]);
      A.col(k).tail(4) = A.row(k).tail(4).transpose();
      right.row(k) = points.u[static_cast<std::size_t>(k)].transpose();
    }
    weight_ = A.completeOrthogonalDecomposition().solve(right);  // points of a plane leave one slope free: it is zero
  }
  Vec3 at(const Vec3& X) const { return (terms(X) * weight_).transpose(); }

 private:
  Eigen::RowVectorXd terms(const Vec3& X) const {
    const auto n = static_cast<Eigen::Index>(X_.size());
    Eigen::RowVectorXd t(n + 4);
    for (Eigen::Index k = 0; k < n; ++k) {
      const double r2 = (X - X_[static_cast<std::size_t>(k)]).squaredNorm() / (scale_ * scale_);
      t[k] = r2 > 0 ? 0.5 * r2 * std::log(r2) : 0;
    }
    t[n] = 1;
    for (int a = 0; a < 3; ++a) t[n + 1 + a] = (X[a] - middle_[a]) / scale_;
    return t;
  }

  std::vector<Vec3> X_;
  Vec3 middle_;
  double scale_;
  Eigen::MatrixXd weight_;  // (point_count + 4, 3)
};

/// Keeps points that are far enough from all before.
class Spread {
 public:
  explicit Spread(double apart) : apart_(apart) {}
  void add(const Vec3& X, double free) { place_[cellOf(X)].push_back({X, free}); }
  bool isFree(const Vec3& X) const {
    const Cell at = cellOf(X);
    for (int n = 0; n < 27; ++n) {
      const auto cell = place_.find({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1});
      if (cell == place_.end()) continue;
      for (const auto& [other, free] : cell->second)
        if ((other - X).squaredNorm() < free * free) return false;
    }
    return true;
  }

 private:
  using Cell = std::array<int, 3>;
  Cell cellOf(const Vec3& X) const {
    Cell at{};
    for (int a = 0; a < 3; ++a) at[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(X[a] / apart_));
    return at;
  }
  double apart_;
  std::map<Cell, std::vector<std::pair<Vec3, double>>> place_;
};

}  // namespace

MovedPoints sheetBetween(const MovedPoints& measured, const SurfaceTree& organ, double apart) {
  MovedPoints sheet;
  constexpr double least_width = 1e-3;  // of the length: narrower is a line
  if (measured.X.size() < 3) return sheet;
  Plane plane(measured.X);
  if (!(plane.width > least_width * plane.length)) return sheet;
  const TriangleSurface& surface = organ.surface();
  double facing = 0;
  for (const Vec3& X : measured.X)
    facing += areaVector(surface, organ.closest(X).triangle).normalized().dot(plane.normal);
  if (facing < 0) plane.normal = -plane.normal;

  std::vector<Vec2> flat;
  double lowest = 0, highest = 0;  // m above the plane
  for (const Vec3& X : measured.X) {
    flat.push_back(plane.at(X));
    const double height = (X - plane.middle).dot(plane.normal);
    lowest = std::min(lowest, height), highest = std::max(highest, height);
  }
  const std::vector<Vec2> hull = hullOf(flat);
  const double between = distanceOf(measured.X), margin = 0.5 * between;
  const ThinPlate plate(measured, plane.middle, plane.length);
  Spread kept(apart);
  for (const Vec3& X : measured.X) kept.add(X, 0.75 * apart);
  const auto consider = [&](const Vec3& X) {
    const double height = (X - plane.middle).dot(plane.normal);
    if (height < lowest - between || height > highest + between) return;  // another fold
    if (!isOver(hull, plane.at(X), margin) || !kept.isFree(X)) return;
    kept.add(X, apart);
    sheet.X.push_back(X);
    sheet.u.push_back(plate.at(X));
  };
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 &A = surface.vertices[a], &B = surface.vertices[b], &C = surface.vertices[c];
    if ((B - A).cross(C - A).dot(plane.normal) <= 0) continue;  // the far side
    const double longest = std::max({(B - A).norm(), (C - A).norm(), (C - B).norm()});
    const Vec3 nearest = A + 0.5 * (B - A);
    if (!isOver(hull, plane.at(nearest), margin + longest)) continue;
    const int n = std::max(1, static_cast<int>(std::ceil(2 * longest / apart)));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) consider(A + (B - A) * i / n + (C - A) * j / n);
  }
  return sheet;
}

}  // namespace palpate

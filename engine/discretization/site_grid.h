#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "base/types.h"

namespace palpate {

/// A node, or a place where one may come to be.
struct Site {
  Vec3 X = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // of the face it lies on, outward; zero on edges, corners and inside
  double h = 0;                // m, the spacing wanted there
};

/// Copies of sites, sorted into the cells of a regular grid: for all sites' neighbours at once. Rows of cells lie in
/// memory one after another, which makes it several times faster to ask than PointGrid, but it can't grow.
class SiteGrid {
 public:
  /// @param box   where the sites will be; those outside are kept in the border cells
  /// @param cell  edge of a cell, m; best near the search radius. Enlarged where it would need
  ///              more than 4 million cells.
  SiteGrid(const Eigen::AlignedBox3d& box, double cell);

  /// Takes the place of all sites before.
  void assign(const std::vector<Site>& sites);

  int size() const { return static_cast<int>(index_.size()); }
  /// The site at a place in the grid's order, in which neighbours are near each other.
  int indexAt(int place) const { return index_[place]; }

  /// Calls visit(X, h, normal) for all sites within `radius` of x, in an order that depends only on theirs.
  template <class Visit>
  void forEachWithin(const Vec3& x, double radius, Visit&& visit) const {
    const Eigen::Array3i low = cellOf(x - Vec3::Constant(radius));
    const Eigen::Array3i high = cellOf(x + Vec3::Constant(radius));
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int e = first_[slot({low.x(), j, k})]; e < first_[slot({high.x(), j, k}) + 1]; ++e) {
          const Ball& ball = ball_[e];
          if ((ball.X - x).squaredNorm() <= radius * radius) visit(ball.X, ball.h, normal_[e]);
        }
  }

 private:
  struct Ball {
    Vec3 X;
    double h;
  };

  Eigen::Array3i cellOf(const Vec3& x) const {
    const Eigen::Array3d place = ((x - origin_) / cell_).array();
    return place.max(0.0).min((count_ - 1).cast<double>()).cast<int>();
  }
  std::size_t slot(const Eigen::Array3i& c) const {
    return (static_cast<std::size_t>(c.z()) * count_.y() + c.y()) * count_.x() + c.x();
  }

  Vec3 origin_;
  double cell_;
  Eigen::Array3i count_;
  std::vector<int> first_;      // (cells + 1) places
  std::vector<std::size_t> slot_of_;  // (sites) scratch
  std::vector<Ball> ball_;      // (sites) in the grid's order, as the next two
  std::vector<Vec3> normal_;
  std::vector<int> index_;
};

}  // namespace palpate

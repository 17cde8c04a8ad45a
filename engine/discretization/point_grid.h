#pragma once

#include <vector>

#include "base/types.h"

namespace palpate {

/// Points in the cells of a regular grid, for neighbour searches while points are being added.
/// (A k-d tree is faster to ask but can't grow.)
class PointGrid {
 public:
  /// @param box   where the points will be; points outside are kept in the border cells
  /// @param cell  edge of a cell, m; best near the search radius. Enlarged where it would need
  ///              more than 4 million cells.
  PointGrid(const Eigen::AlignedBox3d& box, double cell);

  void clear();
  void add(int index, const Vec3& x);

  /// Calls visit(index, position) for all points within `radius` of x, in an order that depends only on
  /// the order in which they were added; until visit returns false.
  template <class Visit>
  void forEachWithin(const Vec3& x, double radius, Visit&& visit) const {
    const Eigen::Array3i low = cellOf(x - Vec3::Constant(radius));
    const Eigen::Array3i high = cellOf(x + Vec3::Constant(radius));
    for (int k = low.z(); k <= high.z(); ++k) {
      for (int j = low.y(); j <= high.y(); ++j) {
        for (int i = low.x(); i <= high.x(); ++i) {
          for (int e = first_[slot({i, j, k})]; e >= 0; e = entries_[e].next) {
            const Entry& entry = entries_[e];
            if ((entry.x - x).squaredNorm() <= radius * radius && !visit(entry.index, entry.x)) return;
          }
        }
      }
    }
  }

 private:
  struct Entry {
    Vec3 x;
    int index;
    int next;  // in the same cell, or -1
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
  std::vector<int> first_;  // (cells) first entry, or -1
  std::vector<Entry> entries_;
};

}  // namespace palpate

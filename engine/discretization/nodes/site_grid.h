#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "base/types.h"

namespace palpate {

/// A node, or a place where a node may be put.
struct Site {
  Vec3 X = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  // of the face it lies on, outward; zero on edges, corners and inside
  double h = 0;                // m, the spacing wanted there
};

/// Copies of sites in the cells of a regular grid, for neighbour searches while sites are being added or all move.
/// (A k-d tree is faster to search, but can't grow.)
class SiteGrid {
 public:
  /// @param box   where the sites will be; those outside are kept in the border cells
  /// @param cell  edge of a cell, m; best near the search radius. Enlarged where it would need
  ///              more than 4 million cells.
  SiteGrid(const Box3& box, double cell);

  /// Replaces all sites. The sites of a cell are then contiguous in memory, so that searches are faster than after a
  /// series of additions; the results are the same.
  void assign(const std::vector<Site>& sites);
  void clear();
  /// The site gets the next index, counted from 0.
  void add(const Site& site);

  int size() const { return static_cast<int>(entry_.size()); }
  /// Index of the site at a place in the grid's order, in which neighbours are near each other.
  /// @pre nothing was added since assign
  int indexAt(int place) const { return entry_[place].index; }

  /// Calls visit(index, site) for all sites within `radius` of x, in an order that depends only on
  /// the order in which they were added; until visit returns false.
  template <class Visit>
  void forEachWithin(const Vec3& x, double radius, Visit&& visit) const {
    const Eigen::Array3i low = cellOf(x - Vec3::Constant(radius));
    const Eigen::Array3i high = cellOf(x + Vec3::Constant(radius));
    for (int k = low.z(); k <= high.z(); ++k)
      for (int j = low.y(); j <= high.y(); ++j)
        for (int i = low.x(); i <= high.x(); ++i)
          for (int e = first_[slot({i, j, k})]; e >= 0; e = entry_[e].next) {
            const Entry& entry = entry_[e];
            if ((entry.site.X - x).squaredNorm() <= radius * radius && !visit(entry.index, entry.site)) return;
          }
  }

 private:
  struct Entry {
    Site site;
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
  std::vector<int> first_;  // (cells) entry of the site added last, or -1
  std::vector<Entry> entry_;
};

}  // namespace palpate

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Takes from the support of a point x the nodes that do not carry it although they are near; pure, any thread.
/// @param X  of all nodes, m
using SupportLimit = std::function<void(const Vec3& x, const std::vector<Vec3>& X, std::vector<int>& support)>;

/// Finds the nodes whose support contains a point: |x - X_j| < R_j, the nodes' own radii.
/// Immutable once made; queries may run on several threads at once.
class Neighbours {
 public:
  /// @param X       node positions, m   (node_count); kept by reference
  /// @param radius  support radii, m    (node_count), as they are now
  /// @param limit   of what is found; null: none
  Neighbours(const std::vector<Vec3>& X, const std::vector<double>& radius, SupportLimit limit = {});
  ~Neighbours();

  /// Support of x in ascending node order; `support` is overwritten.
  void find(const Vec3& x, std::vector<int>& support) const;

  /// The k nodes nearest to x, nearest first.
  std::vector<int> nearest(const Vec3& x, int k) const;

 private:
  struct Tree;
  void fillGrid(const std::vector<double>& radius);
  Eigen::Array3i cellOf(const Vec3& x) const;
  std::size_t slot(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * count_.y() + j) * count_.x() + i;
  }

  const std::vector<Vec3>& X_;
  const SupportLimit limit_;
  double max_radius_ = 0;
  std::unique_ptr<Tree> tree_;  // for nearest

  // For find: the nodes in the cells of a regular grid, rows of cells one after another.
  struct Ball {
    Vec3 X;
    double radius2;  // m^2
  };
  Vec3 origin_ = Vec3::Zero();
  double cell_ = 1;  // m
  Eigen::Array3i count_ = Eigen::Array3i::Ones();
  std::vector<int> first_;  // (cells + 1)
  std::vector<Ball> ball_;  // (node_count)
  std::vector<int> node_;   // (node_count) ascending in each cell
};

}  // namespace palpate

#pragma once

#include <memory>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Finds the nodes whose support contains a point: |x - X_j| < R_j, the nodes' own radii.
/// Immutable once made; queries may run on several threads at once.
class Neighbours {
 public:
  /// @param X       node positions, m   (node_count); kept by reference
  /// @param radius  support radii, m    (node_count); kept by reference
  Neighbours(const std::vector<Vec3>& X, const std::vector<double>& radius);
  ~Neighbours();

  /// Support of x in ascending node order; `support` is overwritten.
  void find(const Vec3& x, std::vector<int>& support) const;

  /// The k nodes nearest to x, nearest first.
  std::vector<int> nearest(const Vec3& x, int k) const;

 private:
  struct Tree;
  const std::vector<Vec3>& X_;
  const std::vector<double>& radius_;
  double max_radius_ = 0;
  std::unique_ptr<Tree> tree_;
};

}  // namespace palpate

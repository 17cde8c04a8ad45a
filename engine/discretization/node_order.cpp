#include "discretization/node_order.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace palpate {
namespace {

struct Bisection {
  const std::vector<Vec3>& X;
  int leaf;

  /// Sorts order[begin, end) so that each half, quarter, ... is compact.
  void split(std::vector<int>& order, std::size_t begin, std::size_t end) const {
    const std::size_t leaf_count = (end - begin + leaf - 1) / leaf;
    if (leaf_count <= 1) {
      std::sort(order.begin() + begin, order.begin() + end);
      return;
    }
    // Above one block of 4 leaves the cut falls on a block's border, so that blocks stay whole.
    const std::size_t unit = leaf_count > 4 ? 4 : 1;
    const std::size_t left = std::max<std::size_t>(1, (leaf_count / 2 + unit / 2) / unit) * unit;
    const std::size_t middle = begin + left * leaf;

    halve(order, begin, middle, end, longestAxis(order, begin, end));
    split(order, begin, middle);
    split(order, middle, end);
  }

  /// Cuts [begin, end) into slices across an axis and splits each.
  void slice(std::vector<int>& order, std::size_t begin, std::size_t end, int slices, int axis) const {
    const std::size_t unit = static_cast<std::size_t>(leaf) * 4;
    const std::size_t middle = begin + (end - begin) * (slices / 2) / slices / unit * unit;
    if (slices == 1 || middle == begin) {
      split(order, begin, end);
      return;
    }
    halve(order, begin, middle, end, axis);
    slice(order, begin, middle, slices / 2, axis);
    slice(order, middle, end, slices - slices / 2, axis);
  }

  int longestAxis(const std::vector<int>& order, std::size_t begin, std::size_t end) const {
    Vec3 low = X[order[begin]], high = low;
    for (std::size_t k = begin; k < end; ++k) {
      low = low.cwiseMin(X[order[k]]);
      high = high.cwiseMax(X[order[k]]);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    return axis;
  }

  /// Brings the points with the least coordinates to the front, up to `middle`.
  void halve(std::vector<int>& order, std::size_t begin, std::size_t middle, std::size_t end, int axis) const {
    // The index breaks ties, so equal coordinates can't make the result depend on the library.
    const auto before = [&](int a, int b) {
      return X[a][axis] != X[b][axis] ? X[a][axis] < X[b][axis] : a < b;
    };
    std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end, before);
  }
};

}  // namespace

std::vector<int> bisectionOrder(const std::vector<Vec3>& X, int leaf) {
  assert(leaf > 0);
  std::vector<int> order(X.size());
  std::iota(order.begin(), order.end(), 0);
  if (!X.empty()) Bisection{X, leaf}.split(order, 0, X.size());
  return order;
}

std::vector<int> slicedOrder(const std::vector<Vec3>& X, int leaf, double thick) {
  assert(leaf > 0 && thick > 0);
  std::vector<int> order(X.size());
  std::iota(order.begin(), order.end(), 0);
  if (X.empty()) return order;
  Eigen::AlignedBox3d box;
  for (const Vec3& x : X) box.extend(x);
  const double distance = std::cbrt(box.volume() / static_cast<double>(X.size()));
  Eigen::Index axis = 0;
  const double length = box.sizes().maxCoeff(&axis);
  const double slices = distance > 0 ? std::clamp(length / (thick * distance), 1.0, static_cast<double>(X.size())) : 1;
  Bisection{X, leaf}.slice(order, 0, X.size(), static_cast<int>(slices), static_cast<int>(axis));
  return order;
}

}  // namespace palpate

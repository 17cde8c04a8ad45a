#include "discretization/nodes/node_order.h"

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
  void slice(std::vector<int>& order, std::size_t begin, std::size_t end, double thick, int axis) const {
    const std::size_t unit = static_cast<std::size_t>(leaf) * 4;
    const std::size_t middle = begin + (end - begin) / 2 / unit * unit;
    const Box3 box = boxOf(order, begin, end);
    const double distance = std::cbrt(box.volume() / static_cast<double>(end - begin));
    if (middle == begin || !(distance > 0) || box.sizes()[axis] < 2 * thick * distance) {
      split(order, begin, end);
      return;
    }
    halve(order, begin, middle, end, axis);
    slice(order, begin, middle, thick, axis);
    slice(order, middle, end, thick, axis);
  }

  Box3 boxOf(const std::vector<int>& order, std::size_t begin, std::size_t end) const {
    Box3 box;
    for (std::size_t k = begin; k < end; ++k) box.extend(X[order[k]]);
    return box;
  }

  int longestAxis(const std::vector<int>& order, std::size_t begin, std::size_t end) const {
    Eigen::Index axis = 0;
    boxOf(order, begin, end).sizes().maxCoeff(&axis);
    return static_cast<int>(axis);
  }

  /// Brings the points with the least coordinates to the front, up to `middle`.
  void halve(std::vector<int>& order, std::size_t begin, std::size_t middle, std::size_t end, int axis) const {
    // The index breaks ties, so equal coordinates can't make the result depend on the library.
    const auto before = [&](int a, int b) { return X[a][axis] != X[b][axis] ? X[a][axis] < X[b][axis] : a < b; };
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
  const Bisection bisection{X, leaf};
  if (!X.empty()) bisection.slice(order, 0, X.size(), thick, bisection.longestAxis(order, 0, X.size()));
  return order;
}

}  // namespace palpate

#pragma once

#include <vector>

#include "base/types.h"

namespace palpate {

/// Recursive coordinate bisection: halves the points at the median of the longest side of
/// their bounding box until `leaf` are left. Consecutive groups of `leaf` points are close
/// together, and so are consecutive groups of 4 leaves (both aligned at the list's start).
/// This order keeps the union support of a block of integration points small.
///
/// @param X     positions, finite                          (point_count)
/// @param leaf  points in a group, > 0; only the last group may be smaller
/// @return order[k] = index in X of the k-th point; a permutation.
std::vector<int> bisectionOrder(const std::vector<Vec3>& X, int leaf);

/// Slices along the longest side of the points' bounding box, each in bisection order. Points that lie close together
/// are at most about two slices apart in the list, so a pass over the list works on only a few slices at a time.
///
/// @param leaf   as in bisectionOrder; slices are whole numbers of 4 leaves
/// @param thick  smallest thickness of a slice, in mean distances between the points around it, > 0; slices are at most
///               about twice as thick
/// @return order[k] = index in X of the k-th point; a permutation.
std::vector<int> slicedOrder(const std::vector<Vec3>& X, int leaf, double thick);

/// An array in the new order: entry k is values[order[k]].
template <class T>
std::vector<T> reordered(const std::vector<T>& values, const std::vector<int>& order) {
  std::vector<T> result;
  result.reserve(order.size());
  for (int i : order) result.push_back(values[i]);
  return result;
}

}  // namespace palpate

#pragma once

#include <vector>

#include "approximation/shape_table.h"

namespace palpate {

/// A shape table read by node: which points each node supports. Sums over points at a node then run on several
/// cores, each node's in ascending order of points, which is that of a loop over points.
struct NodeEntries {
  std::vector<int> begin;  // (node_count + 1)
  std::vector<int> entry;  // (entry_count) into the table's node, N and gradN
  std::vector<int> point;  // (entry_count) the entry's row

  int nodeCount() const { return static_cast<int>(begin.size()) - 1; }
};

NodeEntries nodeEntries(const ShapeTable& shape, std::size_t node_count);

}  // namespace palpate

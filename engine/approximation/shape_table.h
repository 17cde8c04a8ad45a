#pragma once

#include <vector>

#include "base/types.h"

namespace palpate {

/// Shape functions of many evaluation points, in compressed rows: row r holds
/// the support nodes of point r in ascending order, entries begin[r] .. begin[r+1]-1.
struct ShapeTable {
  std::vector<int> begin;   // (row_count + 1)
  std::vector<int> node;    // (entry_count)
  std::vector<double> N;    // (entry_count)
  std::vector<Vec3> gradN;  // (entry_count), 1/m; empty where only values were asked for

  int rowCount() const { return begin.empty() ? 0 : static_cast<int>(begin.size()) - 1; }
  double meanSupport() const { return rowCount() == 0 ? 0.0 : static_cast<double>(node.size()) / rowCount(); }
};

}  // namespace palpate

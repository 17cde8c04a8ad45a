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

  /// A row of another table at the end, without gradients. @pre  begin is not empty
  void appendValues(const ShapeTable& from, int row) {
    const int first = from.begin[row], end = from.begin[row + 1];
    node.insert(node.end(), from.node.begin() + first, from.node.begin() + end);
    N.insert(N.end(), from.N.begin() + first, from.N.begin() + end);
    begin.push_back(static_cast<int>(node.size()));
  }

  /// A row of another table at the end, continued from its point to one that is `way` (m) from it.
  void append(const ShapeTable& from, int row, const Vec3& way = Vec3::Zero()) {
    for (int e = from.begin[row]; e < from.begin[row + 1]; ++e) {
      node.push_back(from.node[e]);
      N.push_back(from.gradN.empty() ? from.N[e] : from.N[e] + from.gradN[e].dot(way));
      if (!from.gradN.empty()) gradN.push_back(from.gradN[e]);
    }
    begin.push_back(static_cast<int>(node.size()));
  }
};

/// What a row makes of a nodal field: sum_i N_i value(i).
/// @param rows  a ShapeTable, or what has its begin, node and N
template <class Rows, class Value>
Vec3 fieldAt(const Rows& rows, std::size_t row, const Value& value) {
  Vec3 sum = Vec3::Zero();
  for (int e = rows.begin[row]; e < rows.begin[row + 1]; ++e) sum += rows.N[e] * value(rows.node[e]);
  return sum;
}

}  // namespace palpate

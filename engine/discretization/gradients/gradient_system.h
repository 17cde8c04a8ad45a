#pragma once

#include <Eigen/Core>
#include <Eigen/StdVector>
#include <vector>

#include "approximation/node_entries.h"
#include "approximation/shape_table.h"
#include "base/types.h"

namespace palpate {

using NodeField = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // one vector per node
template <class T>
using AlignedList = std::vector<T, Eigen::aligned_allocator<T>>;

/// A sparse symmetric matrix over the nodes. Both triangles are stored, row by row.
struct NodeMatrix {
  std::vector<std::size_t> begin;  // (node_count + 1)
  std::vector<int> column;         // (entry_count) ascending in each row
  std::vector<double> value;       // (entry_count)

  int rows() const { return static_cast<int>(begin.size()) - 1; }
  /// y = A x, on all cores.
  void apply(const NodeField& x, NodeField& y) const;
};

/// The projections I - p^T M_q^-1 p of correctGradients at all points, and their sum over points. With M = L L^T
/// and g = L^-1 p a projection is I - g^T g.
class GradientSystem {
 public:
  /// Keeps references to its arguments. @param shape  only N is read, not gradN
  GradientSystem(const ShapeTable& shape, const NodeEntries& entries, const std::vector<Vec3>& point_X,
                 const std::vector<double>& volume, const std::vector<Vec3>& X);

  /// A_ij = sum_q V_q (delta_ij - g_iq . g_jq): each row has about 6 times as many entries as a support has
  /// nodes. It takes a tenth of the memory of the points' own projections, and reading memory is what a product costs.
  NodeMatrix matrix() const;

  /// gradN_iq += lambda_i - g_iq . sum_j g_jq lambda_j
  void correct(const NodeField& lambda, std::vector<Vec3>& gradN) const;

 private:
  const ShapeTable& shape_;
  const NodeEntries& entries_;
  const std::vector<double>& volume_;
  AlignedList<Eigen::Vector4d> g_;  // (entry_count)
};

}  // namespace palpate

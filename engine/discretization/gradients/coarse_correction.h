#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "base/types.h"
#include "discretization/gradients/gradient_system.h"

namespace palpate {

/// Preconditioner of the system of correctGradients. The energy of that system measures how far a field is from linear
/// over each support. It behaves like a bending plate's: its condition number grows with the fourth power of the number
/// of nodes across the body.
///
///   z = sum_b A_bb^-1 r_b  +  P (P^T A P)^-1 P^T r
///
/// with disjoint blocks b of neighbouring nodes, and a coarse space of one linear field per block, blended by a smooth
/// partition of unity: it contains all linear fields and approximates smooth ones. The linear part of z, which rounding
/// would amplify, is removed.
class CoarseCorrection {
 public:
  /// @param A  positive semidefinite, null space: the linear fields
  /// @param X  nodes, m (node_count)
  CoarseCorrection(const NodeMatrix& A, const std::vector<Vec3>& X);

  /// z from r, on all cores.
  void apply(const NodeField& r, NodeField& z) const;

 private:
  struct Share {
    int block;
    Eigen::Vector4d value;  // of the block's four coarse functions
  };
  void findLinearFields(const std::vector<Vec3>& X);
  void findShares(const std::vector<Vec3>& X);
  void factorBlocks(const NodeMatrix& A);
  void factorCoarse(const NodeMatrix& A);

  Eigen::Matrix<double, Eigen::Dynamic, 4> linear_;  // (node_count) orthonormal basis of the linear fields
  std::vector<std::vector<int>> block_;              // (block_count) their nodes, ascending
  std::vector<std::vector<Share>> shares_;           // (node_count) ascending in block: P's rows
  std::vector<std::vector<int>> reach_;              // (block_count) nodes in which the block has a share, ascending
  std::vector<Eigen::LLT<Eigen::MatrixXd>> block_factor_;
  Eigen::LLT<Eigen::MatrixXd> coarse_factor_;
};

}  // namespace palpate

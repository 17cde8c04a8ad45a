#include "discretization/gradients/coarse_correction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "approximation/neighbours.h"
#include "approximation/weight_function.h"
#include "base/input_error.h"
#include "base/parallel_for.h"
#include "discretization/nodes/node_order.h"

namespace palpate {
namespace {

/// Nodes per block, and the most blocks: the coarse matrix is dense, four rows a block.
constexpr int block_size = 64;
constexpr int max_blocks = 600;
/// Reach of a block's coarse functions, in units of the radius of the ball around its nodes. Liver, 4,801 nodes, to
/// 1e-6: 19 iterations; with 1.6 the functions hardly overlap at the ends of long blocks: 45.
constexpr double overlap = 2.2;
/// Added to the diagonals, relative to them: linear fields are in the null space, and a right-hand side has none.
constexpr double shift = 1e-10;

/// Factors a matrix that is positive but for rounding: more is added to the diagonal until it is so in fact. The coarse
/// functions of two or three nodes that reach no others are dependent; those of a single block are the linear
/// fields, and
/// their matrix is nothing but rounding.
Eigen::LLT<Eigen::MatrixXd> factored(Eigen::MatrixXd A) {
  const double size = std::max(A.diagonal().cwiseAbs().mean(), std::numeric_limits<double>::min());
  A.diagonal() *= 1 + shift;
  Eigen::LLT<Eigen::MatrixXd> factor(A);
  for (double more = 100 * shift; factor.info() != Eigen::Success && more < 1e8; more *= 100) {
    A.diagonal().array() += more * size;
    factor.compute(A);
  }
  if (factor.info() != Eigen::Success)
    throw InputError({}, "the gradients can't be made consistent", "give another discretization.seed, or spacing");
  return factor;
}

}  // namespace

CoarseCorrection::CoarseCorrection(const NodeMatrix& A, const std::vector<Vec3>& X) {
  const int nodes = static_cast<int>(X.size());
  const int size = std::max(block_size, (nodes + max_blocks - 1) / max_blocks);
  const std::vector<int> order = bisectionOrder(X, size);
  for (int first = 0; first < nodes; first += size) {
    block_.emplace_back(order.begin() + first, order.begin() + std::min(first + size, nodes));
    std::sort(block_.back().begin(), block_.back().end());
  }
  findLinearFields(X);
  findShares(X);
  factorBlocks(A);
  factorCoarse(A);
}

void CoarseCorrection::findLinearFields(const std::vector<Vec3>& X) {
  Vec3 low = X[0], high = X[0];
  for (const Vec3& x : X) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const auto nodes = static_cast<Eigen::Index>(X.size());
  linear_.resize(nodes, 4);
  for (Eigen::Index i = 0; i < nodes; ++i)
    linear_.row(i) << 1, ((X[i] - (low + high) / 2) / (high - low).maxCoeff()).transpose();
  for (int pass = 0; pass < 2; ++pass)  // Gram and Schmidt; the second pass takes out the first one's rounding
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < a; ++b) linear_.col(a) -= linear_.col(b).dot(linear_.col(a)) * linear_.col(b);
      linear_.col(a).normalize();
    }
}

void CoarseCorrection::findShares(const std::vector<Vec3>& X) {
  std::vector<Vec3> centre;
  std::vector<double> radius;
  for (const auto& block : block_) {
    Vec3 sum = Vec3::Zero();
    for (const int i : block) sum += X[i];
    centre.push_back(sum / static_cast<double>(block.size()));
    double farthest = 0;
    for (const int i : block) farthest = std::max(farthest, (X[i] - centre.back()).norm());
    radius.push_back(farthest > 0 ? overlap * farthest : 1);  // a block of one node: any length will do
  }
  const Neighbours blocks(centre, radius);
  shares_.resize(X.size());
  parallelFor(static_cast<int>(X.size()), [&](int first, int last) {
    std::vector<int> near;
    for (int i = first; i < last; ++i) {
      blocks.find(X[i], near);  // the node's own block at least
      double total = 0;
      for (const int b : near) {
        const Vec3 arm = (X[i] - centre[b]) / radius[b];
        const double weight = quarticSpline(arm.norm());
        shares_[i].push_back({b, weight * Eigen::Vector4d(1, arm[0], arm[1], arm[2])});
        total += weight;
      }
      for (Share& share : shares_[i]) share.value /= total;
    }
  });
  reach_.resize(block_.size());
  for (std::size_t i = 0; i < X.size(); ++i)
    for (const Share& share : shares_[i]) reach_[share.block].push_back(static_cast<int>(i));
}

void CoarseCorrection::factorBlocks(const NodeMatrix& A) {
  block_factor_.resize(block_.size());
  parallelFor(
      static_cast<int>(block_.size()),
      [&](int first, int last) {
        for (int b = first; b < last; ++b) {
          const auto n = static_cast<Eigen::Index>(block_[b].size());
          Eigen::MatrixXd own = Eigen::MatrixXd::Zero(n, n);
          for (Eigen::Index r = 0; r < n; ++r) {
            const int i = block_[b][r];
            for (std::size_t k = A.begin[i]; k < A.begin[i + 1]; ++k) {
              const auto at = std::lower_bound(block_[b].begin(), block_[b].end(), A.column[k]);
              if (at != block_[b].end() && *at == A.column[k]) own(r, at - block_[b].begin()) = A.value[k];
            }
          }
          block_factor_[b] = factored(std::move(own));
        }
      },
      1);
}

void CoarseCorrection::factorCoarse(const NodeMatrix& A) {
  const int blocks = static_cast<int>(block_.size());
  std::vector<std::vector<Share>> AP(shares_.size());  // rows of A P
  parallelFor(static_cast<int>(shares_.size()), [&](int first, int last) {
    AlignedList<Eigen::Vector4d> sum(blocks, Eigen::Vector4d::Zero());
    std::vector<char> touched(blocks, 0);
    for (int i = first; i < last; ++i) {
      for (std::size_t k = A.begin[i]; k < A.begin[i + 1]; ++k)
        for (const Share& share : shares_[A.column[k]]) {
          sum[share.block] += A.value[k] * share.value;
          touched[share.block] = 1;
        }
      // The factorization reads the lower half: what lies right of all of the row's own blocks has no part in it.
      for (int b = 0; b <= shares_[i].back().block; ++b)
        if (touched[b]) AP[i].push_back({b, sum[b]});
      std::fill(sum.begin(), sum.end(), Eigen::Vector4d::Zero());
      std::fill(touched.begin(), touched.end(), 0);
    }
  });
  Eigen::MatrixXd coarse = Eigen::MatrixXd::Zero(4 * blocks, 4 * blocks);
  parallelFor(
      blocks,
      [&](int first, int last) {
        Eigen::Matrix<double, 4, Eigen::Dynamic> rows(4, 4 * blocks);
        for (int b = first; b < last; ++b) {
          rows.setZero();
          for (const int i : reach_[b]) {
            const auto own =
                std::find_if(shares_[i].begin(), shares_[i].end(), [&](const Share& s) { return s.block == b; });
            for (const Share& column : AP[i]) {
              if (column.block > b) break;
              rows.middleCols<4>(4 * column.block) += own->value * column.value.transpose();
            }
          }
          coarse.middleRows<4>(4 * b) = rows;
        }
      },
      1);
  coarse_factor_ = factored(std::move(coarse));
}

void CoarseCorrection::apply(const NodeField& r, NodeField& z) const {
  const int blocks = static_cast<int>(block_.size());
  Eigen::MatrixXd coarse(4 * blocks, 3);
  parallelFor(
      blocks,
      [&](int first, int last) {
        for (int b = first; b < last; ++b) {
          Eigen::Matrix<double, 4, 3> sum = Eigen::Matrix<double, 4, 3>::Zero();
          for (const int i : reach_[b]) {
            const auto own =
                std::find_if(shares_[i].begin(), shares_[i].end(), [&](const Share& s) { return s.block == b; });
            sum += own->value * r.row(i);
          }
          coarse.middleRows<4>(4 * b) = sum;
          Eigen::MatrixXd own(block_[b].size(), 3);
          for (std::size_t k = 0; k < block_[b].size(); ++k)
            own.row(static_cast<Eigen::Index>(k)) = r.row(block_[b][k]);
          block_factor_[b].solveInPlace(own);
          for (std::size_t k = 0; k < block_[b].size(); ++k)
            z.row(block_[b][k]) = own.row(static_cast<Eigen::Index>(k));
        }
      },
      1);
  coarse_factor_.solveInPlace(coarse);
  parallelFor(static_cast<int>(shares_.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i)
      for (const Share& share : shares_[i]) z.row(i) += share.value.transpose() * coarse.middleRows<4>(4 * share.block);
  });
  const Eigen::Matrix<double, 4, 3> linear = linear_.transpose() * z;
  z -= linear_ * linear;
}

}  // namespace palpate

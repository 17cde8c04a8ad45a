#include "discretization/consistent_gradients.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/parallel_for.h"

namespace palpate {
namespace {

using NodeField = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // one vector per node
using Moments = Eigen::Matrix<double, 4, 3>;
template <class T>
using AlignedList = std::vector<T, Eigen::aligned_allocator<T>>;

constexpr int max_iterations = 400;

/// int_boundary N_i n dS.
NodeField boundaryIntegral(const BoundaryPoints& boundary, const ShapeTable& at_boundary, Eigen::Index nodes) {
  NodeField g = NodeField::Zero(nodes, 3);
  for (std::size_t k = 0; k < boundary.X.size(); ++k)
    for (int e = at_boundary.begin[k]; e < at_boundary.begin[k + 1]; ++e)
      g.row(at_boundary.node[e]) += at_boundary.N[e] * boundary.area[k].transpose();
  return g;
}

/// The projections I - p^T M_q^-1 p of all points, and their sum over points. Sums at a node run over its own
/// list of entries: cores share no node, and the order does not depend on their number.
class Projections {
 public:
  Projections(const ShapeTable& shape, const std::vector<Vec3>& point_X, const std::vector<double>& volume,
              const std::vector<Vec3>& X)
      : shape_(shape), volume_(volume), p_(shape.node.size()), inverse_(point_X.size()), fit_(point_X.size()) {
    parallelFor(shape.rowCount(), [&](int first, int last) {
      for (int q = first; q < last; ++q) {
        double R = 0;
        for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) R = std::max(R, (X[shape.node[e]] - point_X[q]).norm());
        Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
        for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
          p_[e] << 1, (X[shape.node[e]] - point_X[q]) / R;
          M += p_[e] * p_[e].transpose();
        }
        inverse_[q] = M.ldlt().solve(Eigen::Matrix4d::Identity());
      }
    });
    node_begin_.assign(X.size() + 1, 0);
    for (const int i : shape.node) ++node_begin_[i + 1];
    for (std::size_t i = 0; i < X.size(); ++i) node_begin_[i + 1] += node_begin_[i];
    node_entry_.resize(shape.node.size());
    node_point_.resize(shape.node.size());
    node_p_.resize(shape.node.size());
    node_volume_.assign(X.size(), 0);
    std::vector<int> next(node_begin_.begin(), node_begin_.end() - 1);
    for (int q = 0; q < shape.rowCount(); ++q)
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
        const int k = next[shape.node[e]]++;
        node_entry_[k] = e;
        node_point_[k] = q;
        node_p_[k] = volume[q] * p_[e];
        node_volume_[shape.node[e]] += volume[q];
      }
  }

  /// The linear field nearest to lambda on each point's support; what dB below is the rest of.
  void fit(const NodeField& lambda) {
    parallelFor(shape_.rowCount(), [&](int first, int last) {
      for (int q = first; q < last; ++q) {
        Moments sum = Moments::Zero();
        for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e) {
          const Eigen::RowVector3d l = lambda.row(shape_.node[e]);
          for (int c = 0; c < 3; ++c) sum.col(c) += l[c] * p_[e];
        }
        fit_[q].noalias() = inverse_[q] * sum;
      }
    });
  }
  Eigen::RowVector3d dB(const NodeField& lambda, int q, int e) const {
    return lambda.row(shape_.node[e]) - p_[e].transpose() * fit_[q];
  }

  /// result_i = sum_q V_q dB_iq of lambda.
  void apply(const NodeField& lambda, NodeField& result) {
    fit(lambda);
    parallelFor(static_cast<int>(node_volume_.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        Eigen::RowVector3d fitted = Eigen::RowVector3d::Zero();
        for (int k = node_begin_[i]; k < node_begin_[i + 1]; ++k) fitted += node_p_[k].transpose() * fit_[node_point_[k]];
        result.row(i) = node_volume_[i] * lambda.row(i) - fitted;
      }
    });
  }

  /// sum_q V_q gradN_iq
  NodeField divergence() const {
    NodeField sum = NodeField::Zero(static_cast<Eigen::Index>(node_begin_.size()) - 1, 3);
    forNodes([&](Eigen::Index i, int q, int e) { sum.row(i) += volume_[q] * shape_.gradN[e].transpose(); });
    return sum;
  }

  Eigen::VectorXd diagonal() const {
    Eigen::VectorXd d = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(node_begin_.size()) - 1);
    forNodes([&](Eigen::Index i, int q, int e) { d[i] += volume_[q] * (1 - p_[e].dot(inverse_[q] * p_[e])); });
    return d;
  }

 private:
  template <class Each>
  void forNodes(Each&& each) const {
    parallelFor(static_cast<int>(node_begin_.size()) - 1, [&](int first, int last) {
      for (int i = first; i < last; ++i)
        for (int k = node_begin_[i]; k < node_begin_[i + 1]; ++k) each(i, node_point_[k], node_entry_[k]);
    });
  }

  const ShapeTable& shape_;
  const std::vector<double>& volume_;
  AlignedList<Eigen::Vector4d> p_;        // (entry_count)
  AlignedList<Eigen::Matrix4d> inverse_;  // (point_count)
  AlignedList<Moments> fit_;              // (point_count) of the last lambda
  std::vector<int> node_begin_, node_entry_, node_point_;  // each node's entries, ascending
  AlignedList<Eigen::Vector4d> node_p_;   // (entry_count) V_q p in that order, so that memory is read as it lies
  std::vector<double> node_volume_;       // (node_count) sum of V_q over them
};

}  // namespace

GradientCorrection correctGradients(ShapeTable& shape, const std::vector<Vec3>& point_X,
                                    const std::vector<double>& volume, const std::vector<Vec3>& X,
                                    const BoundaryPoints& boundary, const ShapeTable& at_boundary, double tolerance) {
  const auto nodes = static_cast<Eigen::Index>(X.size());
  const NodeField target = boundaryIntegral(boundary, at_boundary, nodes);
  Projections projections(shape, point_X, volume, X);
  NodeField r = target - projections.divergence();

  GradientCorrection result;
  result.violation_before = r.norm() / target.norm();
  if (result.violation_before == 0) return result;

  Eigen::VectorXd jacobi = projections.diagonal();
  // A node whose every support is its own projection can't be corrected and needn't be.
  jacobi = (jacobi.array() > 1e-12 * jacobi.maxCoeff()).select(jacobi.cwiseInverse(), 0);

  NodeField lambda = NodeField::Zero(nodes, 3), z = jacobi.asDiagonal() * r, p = z, Ap(nodes, 3);
  // The three components share the operator but are three systems.
  Eigen::RowVector3d rz = (r.cwiseProduct(z)).colwise().sum();
  const Eigen::RowVector3d stop = tolerance * r.colwise().norm();
  for (; result.iterations < max_iterations; ++result.iterations) {
    if ((r.colwise().norm().array() <= stop.array()).all()) break;
    projections.apply(p, Ap);
    const Eigen::RowVector3d pAp = (p.cwiseProduct(Ap)).colwise().sum();
    const Eigen::RowVector3d step = (pAp.array() > 0).select(rz.array() / pAp.array(), 0);
    lambda += p * step.asDiagonal();
    r -= Ap * step.asDiagonal();
    z = jacobi.asDiagonal() * r;
    const Eigen::RowVector3d rz_new = (r.cwiseProduct(z)).colwise().sum();
    const Eigen::RowVector3d ratio = (rz.array() > 0).select(rz_new.array() / rz.array(), 0);
    p = z + p * ratio.asDiagonal();
    rz = rz_new;
  }

  projections.fit(lambda);
  for (int q = 0; q < shape.rowCount(); ++q)
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) shape.gradN[e] += projections.dB(lambda, q, e).transpose();
  result.violation_after = (target - projections.divergence()).norm() / target.norm();
  return result;
}

}  // namespace palpate

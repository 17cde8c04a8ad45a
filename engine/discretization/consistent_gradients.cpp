#include "discretization/consistent_gradients.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace palpate {
namespace {

using Vec4 = Eigen::Vector4d;
using NodeField = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // one vector per node

constexpr int max_iterations = 400;

/// int_boundary N_i n dS by the vertex rule.
NodeField boundaryIntegral(const std::vector<Vec3>& X, const std::vector<std::array<int, 3>>& facets, const ShapeTable& at_nodes) {
  NodeField g = NodeField::Zero(static_cast<Eigen::Index>(X.size()), 3);
  for (const auto& f : facets) {
    const Vec3 third = (X[f[1]] - X[f[0]]).cross(X[f[2]] - X[f[0]]) / 6;
    for (const int v : f)
      for (int e = at_nodes.begin[v]; e < at_nodes.begin[v + 1]; ++e) g.row(at_nodes.node[e]) += at_nodes.N[e] * third;
  }
  return g;
}

/// The projections I - p^T M_q^-1 p of all points.
class Projections {
 public:
  Projections(const ShapeTable& shape, const std::vector<Vec3>& point_X, const std::vector<Vec3>& X)
      : shape_(shape), p_(shape.node.size()), inverse_(point_X.size()) {
    for (int q = 0; q < shape.rowCount(); ++q) {
      double R = 0;
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) R = std::max(R, (X[shape.node[e]] - point_X[q]).norm());
      Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
      for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
        p_[e] << 1, (X[shape.node[e]] - point_X[q]) / R;
        M += p_[e] * p_[e].transpose();
      }
      inverse_[q] = M.ldlt().solve(Eigen::Matrix4d::Identity());
    }
  }

  /// Calls each(e, dB) with dB_iq of lambda for every entry e of point q.
  template <class Each>
  void correction(int q, const NodeField& lambda, Each&& each) const {
    Eigen::Matrix<double, 4, 3> sum = Eigen::Matrix<double, 4, 3>::Zero();
    for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e) sum += p_[e] * lambda.row(shape_.node[e]);
    const Eigen::Matrix<double, 4, 3> s = inverse_[q] * sum;
    for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e)
      each(e, Vec3((lambda.row(shape_.node[e]) - p_[e].transpose() * s).transpose()));
  }

  double diagonal(int q, int e) const { return 1 - p_[e].dot(inverse_[q] * p_[e]); }

 private:
  const ShapeTable& shape_;
  std::vector<Vec4, Eigen::aligned_allocator<Vec4>> p_;                        // (entry_count)
  std::vector<Eigen::Matrix4d, Eigen::aligned_allocator<Eigen::Matrix4d>> inverse_;  // (point_count)
};

NodeField divergence(const ShapeTable& shape, const std::vector<double>& volume, Eigen::Index nodes) {
  NodeField sum = NodeField::Zero(nodes, 3);
  for (int q = 0; q < shape.rowCount(); ++q)
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) sum.row(shape.node[e]) += volume[q] * shape.gradN[e].transpose();
  return sum;
}

}  // namespace

GradientCorrection correctGradients(ShapeTable& shape, const std::vector<Vec3>& point_X,
                                    const std::vector<double>& volume, const std::vector<Vec3>& X,
                                    const std::vector<std::array<int, 3>>& facets, const ShapeTable& at_nodes,
                                    double tolerance) {
  const auto nodes = static_cast<Eigen::Index>(X.size());
  const NodeField target = boundaryIntegral(X, facets, at_nodes);
  NodeField r = target - divergence(shape, volume, nodes);

  GradientCorrection result;
  result.violation_before = r.norm() / target.norm();
  if (result.violation_before == 0) return result;

  const Projections projections(shape, point_X, X);
  Eigen::VectorXd jacobi = Eigen::VectorXd::Zero(nodes);
  for (int q = 0; q < shape.rowCount(); ++q)
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) jacobi[shape.node[e]] += volume[q] * projections.diagonal(q, e);
  // A node whose every support is its own projection can't be corrected and needn't be.
  jacobi = (jacobi.array() > 1e-12 * jacobi.maxCoeff()).select(jacobi.cwiseInverse(), 0);

  NodeField lambda = NodeField::Zero(nodes, 3), z = jacobi.asDiagonal() * r, p = z, Ap(nodes, 3);
  // The three components share the operator but are three systems.
  Eigen::RowVector3d rz = (r.cwiseProduct(z)).colwise().sum();
  const Eigen::RowVector3d stop = tolerance * r.colwise().norm();
  for (; result.iterations < max_iterations; ++result.iterations) {
    if ((r.colwise().norm().array() <= stop.array()).all()) break;
    Ap.setZero();
    for (int q = 0; q < shape.rowCount(); ++q)
      projections.correction(q, p, [&](int e, const Vec3& dB) { Ap.row(shape.node[e]) += volume[q] * dB.transpose(); });
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

  for (int q = 0; q < shape.rowCount(); ++q)
    projections.correction(q, lambda, [&](int e, const Vec3& dB) { shape.gradN[e] += dB; });
  result.violation_after = (target - divergence(shape, volume, nodes)).norm() / target.norm();
  return result;
}

}  // namespace palpate

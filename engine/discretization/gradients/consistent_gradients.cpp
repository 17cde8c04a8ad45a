#include "discretization/gradients/consistent_gradients.h"

#include <cmath>

#include "approximation/node_entries.h"
#include "base/input_error.h"
#include "base/parallel_for.h"
#include "discretization/gradients/coarse_correction.h"
#include "discretization/gradients/gradient_system.h"

namespace palpate {
namespace {

constexpr int max_iterations = 400;

/// int_boundary N_i n dS.
NodeField boundaryIntegral(const BoundaryPoints& boundary, const ShapeTable& at_boundary, Eigen::Index nodes) {
  NodeField g = NodeField::Zero(nodes, 3);
  for (std::size_t k = 0; k < boundary.X.size(); ++k)
    for (int e = at_boundary.begin[k]; e < at_boundary.begin[k + 1]; ++e)
      g.row(at_boundary.node[e]) += at_boundary.N[e] * boundary.area[k].transpose();
  return g;
}

/// sum_q V_q gradN_iq
NodeField divergence(const ShapeTable& shape, const NodeEntries& entries, const std::vector<double>& volume) {
  NodeField sum = NodeField::Zero(entries.nodeCount(), 3);
  parallelFor(entries.nodeCount(), [&](int first, int last) {
    for (int i = first; i < last; ++i)
      for (int k = entries.begin[i]; k < entries.begin[i + 1]; ++k)
        sum.row(i) += volume[entries.point[k]] * shape.gradN[entries.entry[k]].transpose();
  });
  return sum;
}

}  // namespace

GradientCorrection correctGradients(ShapeTable& shape, const std::vector<Vec3>& point_X,
                                    const std::vector<double>& volume, const std::vector<Vec3>& X,
                                    const BoundaryPoints& boundary, const ShapeTable& at_boundary, double tolerance) {
  const auto nodes = static_cast<Eigen::Index>(X.size());
  const NodeEntries entries = nodeEntries(shape, X.size());
  BoundaryPoints balanced = boundary;
  balanceNodes(balanced, at_boundary);
  const NodeField target = boundaryIntegral(balanced, at_boundary, nodes);
  NodeField r = target - divergence(shape, entries, volume);

  GradientCorrection result;
  result.violation_before = r.norm() / target.norm();
  if (result.violation_before == 0) return result;

  const GradientSystem system(shape, entries, point_X, volume, X);
  const NodeMatrix A = system.matrix();
  const CoarseCorrection precondition(A, X);

  NodeField lambda = NodeField::Zero(nodes, 3), z(nodes, 3), Ap(nodes, 3);
  precondition.apply(r, z);
  NodeField p = z;
  // The three components share the operator but are three systems.
  Eigen::RowVector3d rz = (r.cwiseProduct(z)).colwise().sum();
  const Eigen::RowVector3d stop = tolerance * r.colwise().norm();
  for (; result.iterations < max_iterations; ++result.iterations) {
    if ((r.colwise().norm().array() <= stop.array()).all()) break;
    A.apply(p, Ap);
    const Eigen::RowVector3d pAp = (p.cwiseProduct(Ap)).colwise().sum();
    const Eigen::RowVector3d step = (pAp.array() > 0).select(rz.array() / pAp.array(), 0);
    lambda += p * step.asDiagonal();
    r -= Ap * step.asDiagonal();
    precondition.apply(r, z);
    const Eigen::RowVector3d rz_new = (r.cwiseProduct(z)).colwise().sum();
    const Eigen::RowVector3d ratio = (rz.array() > 0).select(rz_new.array() / rz.array(), 0);
    p = z + p * ratio.asDiagonal();
    rz = rz_new;
  }

  system.correct(lambda, shape.gradN);
  result.violation_after = (target - divergence(shape, entries, volume)).norm() / target.norm();
  if (!std::isfinite(result.violation_after))
    throw InputError({}, "the gradients can't be made consistent", "give another discretization.seed, or spacing");
  return result;
}

}  // namespace palpate

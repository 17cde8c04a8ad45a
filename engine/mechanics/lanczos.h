#pragma once

#include <Eigen/Core>
#include <functional>

namespace palpate {

/// The largest eigenvalue of a symmetric operator.
struct LargestEigenvalue {
  double value = 0;
  double residual = 0;  // an eigenvalue lies within this of `value`; value + residual is a safe estimate
  int iterations = 0;
};

/// Lanczos' iteration, without reorthogonalisation: lost orthogonality only repeats converged Ritz values, which
/// does not change the largest. The start vector is the same at every call.
/// @param apply      y = A x, both of size n
/// @param tolerance  stops when the residual is below this share of the value
LargestEigenvalue largestEigenvalue(Eigen::Index n,
                                    const std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& y)>& apply,
                                    int max_iterations, double tolerance);

}  // namespace palpate

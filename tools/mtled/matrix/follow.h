#pragma once

#include <Eigen/Core>
#include <functional>

namespace palpate::tools {

/// What is 0 in equilibrium. @param load  0 .. 1 of the whole load
using Residual = std::function<Eigen::VectorXd(const Eigen::VectorXd& x, double load)>;

/// Follows residual(x, load) = 0 from x = 0 at no load to all of it by Newton's method, its tangent by differences.
/// @param scale  of x: differences are some 1e-6 of it
/// @param band   entry i of the residual depends on entries i - band .. i + band of x
/// Throws std::runtime_error where no equilibrium is found.
Eigen::VectorXd follow(const Residual& residual, Eigen::Index size, double scale, Eigen::Index band);

}  // namespace palpate::tools

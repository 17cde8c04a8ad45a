#include "mtled/identify/identify.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace palpate::tools {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_iterations = 20;
constexpr double difference = 0.02;  // of a coordinate: far above float32's noise in the forces
constexpr double arrived = 2e-4;     // change of the coordinates: a fiftieth of a percent
constexpr double largest_step = 1;   // a factor of 2.7 at once
constexpr double widest_told = 1;    // half a confidence interval, in coordinates: a factor of 2.7 either way

/// A parameter as an unbounded coordinate.
struct Coordinate {
  double low, high;

  /// A far end (the largest modulus that is accepted) is none.
  Coordinate(const ValueRange& range, double start) : low(range.low), high(range.high) {
    constexpr double near = 0.01;  // of the range
    if (std::isfinite(low) && start - low < near * (high - low)) high = std::numeric_limits<double>::infinity();
  }
  /// A step of one in it is the same share of the value everywhere.
  bool isRelative() const { return std::isfinite(low) || std::isfinite(high); }
  double from(double value) const {
    if (std::isfinite(low) && std::isfinite(high)) {
      const double share = std::clamp((value - low) / (high - low), 1e-3, 1 - 1e-3);
      return std::log(share / (1 - share));
    }
    if (std::isfinite(low)) return std::log(std::max(value - low, 1e-12));
    return std::isfinite(high) ? -std::log(std::max(high - value, 1e-12)) : value;
  }
  double to(double q) const {
    if (std::isfinite(low) && std::isfinite(high)) return low + (high - low) / (1 + std::exp(-q));
    if (std::isfinite(low)) return low + std::exp(q);
    return std::isfinite(high) ? high - std::exp(-q) : q;
  }
};

/// Student's t, two-sided 95 %, by the first terms of its series in 1 / nu: within 0.5 % from nu = 5 on.
double student95(double nu) { return 1.95996 + 2.3723 / nu + 2.8225 / (nu * nu); }

/// Standard errors of the coordinates. Residuals need not all be as large (White, Econometrica 48, 817 (1980)), nor
/// independent: what follows its neighbour counts as fewer rows, n (1 - rho) / (1 + rho) of them for a first-order
/// autoregression (Bayley & Hammersley, J. R. Stat. Soc. Suppl. 8, 184 (1946)). The wider of both and the plain one.
/// @param J  (row_count, parameter_count)  @param r  (row_count)
VectorXd standardErrors(const MatrixXd& J, const VectorXd& r, const MatrixXd& inverse) {
  const auto rows = static_cast<double>(r.size());
  const double freedom = rows - static_cast<double>(J.cols()), sum = r.squaredNorm();
  if (!(sum > 0)) return VectorXd::Zero(J.cols());
  const VectorXd plain = sum / freedom * inverse.diagonal();
  const MatrixXd scaled = r.asDiagonal() * J;
  const VectorXd uneven = rows / freedom * (inverse * (scaled.transpose() * scaled) * inverse).diagonal();
  constexpr double most_alike = 0.99;
  const double rho = std::clamp(r.head(r.size() - 1).dot(r.tail(r.size() - 1)) / sum, 0.0, most_alike);
  return ((1 + rho) / (1 - rho) * plain.cwiseMax(uneven)).cwiseSqrt();
}

}  // namespace

Identified identify(const std::vector<SoughtParameter>& sought,
                    const std::function<std::vector<double>(const std::vector<double>&)>& residuals) {
  const auto count = static_cast<Eigen::Index>(sought.size());
  std::vector<Coordinate> coordinate;
  VectorXd q(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const SoughtParameter& parameter = sought[static_cast<std::size_t>(k)];
    coordinate.emplace_back(parameter.range, parameter.start);
    q[k] = coordinate.back().from(parameter.start);
  }
  Identified result;
  const auto valuesAt = [&](const VectorXd& at) {
    std::vector<double> values;
    for (Eigen::Index k = 0; k < count; ++k) values.push_back(coordinate[static_cast<std::size_t>(k)].to(at[k]));
    return values;
  };
  const auto evaluate = [&](const VectorXd& at) {
    ++result.evaluations;
    const std::vector<double> r = residuals(valuesAt(at));
    return VectorXd(Eigen::Map<const VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())));
  };
  VectorXd r = evaluate(q);
  if (r.size() <= count) throw std::invalid_argument("fewer residuals than parameters to seek");
  MatrixXd J(r.size(), count);
  double lambda = 1e-3;
  for (int iteration = 0; iteration < max_iterations && !result.converged; ++iteration) {
    for (Eigen::Index k = 0; k < count; ++k) {
      VectorXd beside = q;
      beside[k] += difference;
      J.col(k) = (evaluate(beside) - r) / difference;
    }
    const MatrixXd A = J.transpose() * J;
    const VectorXd g = J.transpose() * r;
    bool better = false;
    for (int attempt = 0; attempt < 8 && !better; ++attempt) {
      MatrixXd damped = A;
      damped.diagonal() *= 1 + lambda;
      VectorXd step = -damped.ldlt().solve(g);
      if (!step.allFinite()) break;
      if (step.norm() > largest_step) step *= largest_step / step.norm();
      std::optional<VectorXd> tried;
      try {
        tried = evaluate(q + step);
      } catch (const std::runtime_error&) {  // values at which there is no answer
      }
      better = tried && tried->squaredNorm() <= r.squaredNorm();
      result.converged = step.norm() < arrived;
      if (better) q += step, r = *tried, lambda = std::max(lambda / 10, 1e-9);
      if (result.converged) break;
      if (!better) lambda *= 10;
    }
    if (!better) break;
  }
  result.converged = result.converged || (J.transpose() * r).norm() < 1e-3 * J.norm() * r.norm();

  const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  const VectorXd inverse = s.array().max(1e-12 * s[0]).inverse().square();
  const VectorXd half = student95(static_cast<double>(r.size() - count)) *
                        standardErrors(J, r, svd.matrixV() * inverse.asDiagonal() * svd.matrixV().transpose());
  result.told_apart = s[count - 1] > 1e-3 * s[0];
  for (Eigen::Index k = 0; k < count; ++k)
    if (coordinate[static_cast<std::size_t>(k)].isRelative() && !(half[k] < widest_told)) result.told_apart = false;
  result.value = valuesAt(q);
  result.low = valuesAt(q - half);
  result.high = valuesAt(q + half);
  result.misfit = std::sqrt(r.squaredNorm() / static_cast<double>(r.size()));
  return result;
}

}  // namespace palpate::tools

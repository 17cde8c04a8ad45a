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
constexpr double difference = 0.02;       // of a coordinate: far above float32's noise in the forces
constexpr double arrived = 2e-4;          // change of the coordinates: a fiftieth of a percent
constexpr double hardly_damped = 1e-3;    // lambda, up to which such a step says that it has
constexpr double largest_step = 1;        // a factor of 2.7 at once
constexpr double told_apart_from = 1e-3;  // singular values of the derivatives, as shares of the largest
// Of residuals, where something else explains them. Half may be the cloud's: it is told as a question, and widens the
// intervals only.
constexpr double little_left = 0.5;
constexpr double widest_told = 1;  // half a confidence interval, in coordinates: a factor of 2.7 either way

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

/// Root mean square of what each residual has in common with the next; 0 where that may be chance.
double structureOf(const VectorXd& r) {
  constexpr double chance = 3;  // standard deviations of an autocorrelation of noise, 1 / sqrt(n)
  const auto rows = static_cast<double>(r.size());
  const double common = r.head(r.size() - 1).dot(r.tail(r.size() - 1));
  return common > chance / std::sqrt(rows) * r.squaredNorm() ? std::sqrt(common / rows) : 0;
}

/// The step of the coordinates that takes residuals of `r` away, of some rows. @param J  of those rows
VectorXd stepFor(const MatrixXd& J, const VectorXd& r) {
  Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(told_apart_from);
  VectorXd step = -svd.solve(r);
  const double size = step.norm();
  if (size > largest_step) step *= largest_step / size;
  return step;
}

/// Widens the intervals to the values a step away.
void widenTo(const VectorXd& step, const std::vector<SoughtParameter>& sought, Identified& found) {
  for (std::size_t k = 0; k < sought.size(); ++k) {
    const Coordinate coordinate(sought[k]);
    const double move = step[static_cast<Eigen::Index>(k)];
    double& end = move < 0 ? found.low[k] : found.high[k];
    // What noise makes uncertain is so around the values there, too.
    end = coordinate.to(coordinate.from(end) + move);
  }
}

}  // namespace

Coordinate::Coordinate(const SoughtParameter& parameter) : low_(parameter.range.low), high_(parameter.range.high) {
  constexpr double near = 0.01;  // of the range: a far end (the largest modulus that is accepted) is none
  const double start = parameter.start;
  if (std::isfinite(low_) && start - low_ < near * (high_ - low_)) high_ = std::numeric_limits<double>::infinity();
  if (std::isfinite(low_) || std::isfinite(high_)) return;
  if (start > 0) low_ = 0;
  if (start < 0) high_ = 0;
}

bool Coordinate::isRelative() const { return std::isfinite(low_) || std::isfinite(high_); }

double Coordinate::from(double value) const {
  constexpr double least = 1e-12;
  if (std::isfinite(low_) && std::isfinite(high_)) {
    const double share = std::clamp((value - low_) / (high_ - low_), 1e-3, 1 - 1e-3);
    return std::log(share / (1 - share));
  }
  if (std::isfinite(low_)) return std::log(std::max(value - low_, least));
  return std::isfinite(high_) ? -std::log(std::max(high_ - value, least)) : value;
}

double Coordinate::to(double q) const {
  if (std::isfinite(low_) && std::isfinite(high_)) return low_ + (high_ - low_) / (1 + std::exp(-q));
  if (std::isfinite(low_)) return low_ + std::exp(q);
  return std::isfinite(high_) ? high_ - std::exp(-q) : q;
}

double Coordinate::slopeAt(double q) const {
  if (std::isfinite(low_) && std::isfinite(high_)) return (high_ - low_) / ((1 + std::exp(-q)) * (1 + std::exp(q)));
  if (std::isfinite(low_)) return std::exp(q);
  return std::isfinite(high_) ? std::exp(-q) : 1;
}

Identified identify(const std::vector<SoughtParameter>& sought,
                    const std::function<std::vector<double>(const std::vector<double>&)>& residuals,
                    const std::function<std::vector<std::vector<double>>(const std::vector<double>&)>& derivatives) {
  const auto count = static_cast<Eigen::Index>(sought.size());
  std::vector<Coordinate> coordinate;
  VectorXd q(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const SoughtParameter& parameter = sought[static_cast<std::size_t>(k)];
    coordinate.emplace_back(parameter);
    q[k] = coordinate.back().from(parameter.start);
  }
  Identified result;
  const auto valuesAt = [&](const VectorXd& at) {
    std::vector<double> values;
    for (Eigen::Index k = 0; k < count; ++k) values.push_back(coordinate[static_cast<std::size_t>(k)].to(at[k]));
    return values;
  };
  const auto evaluate = [&](const VectorXd& at) {
    const std::vector<double> r = residuals(valuesAt(at));
    return VectorXd(Eigen::Map<const VectorXd>(r.data(), static_cast<Eigen::Index>(r.size())));
  };
  VectorXd r = evaluate(q);
  if (r.size() <= count) throw std::invalid_argument("fewer residuals than parameters to seek");
  MatrixXd J(r.size(), count);
  double lambda = 1e-3;
  bool central = false;  // in a narrow valley one-sided differences lead astray
  for (int iteration = 0, arrivals = 0; iteration < max_iterations && arrivals == 0; ++iteration) {
    if (derivatives) {
      const std::vector<std::vector<double>> slopes = derivatives(valuesAt(q));
      for (Eigen::Index k = 0; k < count; ++k)
        for (Eigen::Index row = 0; row < r.size(); ++row)
          J(row, k) = slopes[static_cast<std::size_t>(row)][static_cast<std::size_t>(k)] *
                      coordinate[static_cast<std::size_t>(k)].slopeAt(q[k]);
    }
    for (Eigen::Index k = 0; k < count && !derivatives; ++k) {
      VectorXd beside = q;
      beside[k] += difference;
      const VectorXd above = evaluate(beside);
      J.col(k) = (above - r) / difference;
      if (!central) continue;
      beside[k] -= 2 * difference;
      try {
        J.col(k) = (above - evaluate(beside)) / (2 * difference);
      } catch (const std::runtime_error&) {  // values at which there is no answer
      }
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
      if (better) {
        arrivals += step.norm() < arrived && lambda <= hardly_damped;
        q += step, r = *tried, lambda = std::max(lambda / 10, 1e-9);
      } else if (step.norm() < arrived) {
        break;
      } else {
        lambda *= 10;
      }
    }
    if (!better && (central || derivatives)) break;
    if (!better) central = true, lambda = 1e-3;
  }

  const Eigen::JacobiSVD<MatrixXd> svd(J, Eigen::ComputeThinV);
  const VectorXd& s = svd.singularValues();
  const VectorXd inverse = s.array().max(1e-12 * s[0]).inverse().square();
  const auto intervalOf = [&](const VectorXd& left) {
    return VectorXd(student95(static_cast<double>(r.size() - count)) *
                    standardErrors(J, left, svd.matrixV() * inverse.asDiagonal() * svd.matrixV().transpose()));
  };
  const VectorXd half = intervalOf(r);
  result.told_apart = s[count - 1] > told_apart_from * s[0];
  for (Eigen::Index k = 0; k < count; ++k)
    if (coordinate[static_cast<std::size_t>(k)].isRelative() && !(half[k] < widest_told)) result.told_apart = false;
  // By the whole step that is left, or what noise leaves of it: one that is damped may be as short anywhere.
  constexpr double near = 10 * arrived, of_interval = 0.3, longest = 0.05;
  const VectorXd whole = stepFor(J, r), noise = intervalOf(r + J * whole);
  result.converged = (whole.array().abs() < (of_interval * noise).array().min(longest).max(near)).all();
  result.value = valuesAt(q);
  result.low = valuesAt(q - half);
  result.high = valuesAt(q + half);
  result.misfit = std::sqrt(r.squaredNorm() / static_cast<double>(r.size()));
  result.structure = structureOf(r);
  result.J = std::move(J);
  result.r = std::move(r);
  return result;
}

void widenFor(const std::vector<double>& change, const std::vector<SoughtParameter>& sought, Identified& found) {
  const Eigen::Map<const VectorXd> measured(change.data(), static_cast<Eigen::Index>(change.size()));
  widenTo(stepFor(found.J, -measured), sought, found);
}

void widenForError(double share, const std::vector<double>& measured, const std::vector<SoughtParameter>& sought,
                   Identified& found) {
  for (const double way : {-share, share}) {
    std::vector<double> change;
    for (const double force : measured) change.push_back(way * force);
    widenFor(change, sought, found);
  }
}

void widenForErrorAlong(double share, const std::vector<double>& measured, const std::vector<SoughtParameter>& sought,
                        Identified& found) {
  widenForError(share, measured, sought, found);
  const double largest = *std::max_element(measured.begin(), measured.end());
  std::vector<double> beyond;  // a common share
  for (const double force : measured) {
    const double positive = std::max(force, 0.0);
    beyond.push_back(std::cbrt(largest * positive * positive) - positive);
  }
  widenForError(share, beyond, sought, found);
}

double widenForOffset(const std::vector<double>& column, const std::vector<SoughtParameter>& sought,
                      Identified& found) {
  const Eigen::Index count = found.J.cols();
  if (found.r.size() <= count + 1) return 0;
  MatrixXd J(found.r.size(), count + 1);
  J << found.J, Eigen::Map<const VectorXd>(column.data(), found.r.size());
  const VectorXd step = J.colPivHouseholderQr().solve(-found.r), r = found.r + J * step;
  const bool explains = r.norm() < little_left * found.r.norm() ||
                        (found.structure > 0 && structureOf(r) < little_left * found.structure);
  if (!step.allFinite() || !explains) return 0;
  widenTo(step.head(count), sought, found);
  return -step[count];
}

double widenForShift(const std::vector<double>& at, const std::vector<double>& measured,
                     const std::vector<SoughtParameter>& sought, Identified& found) {
  constexpr double most_share = 0.4;     // of the depths' range
  constexpr int tries = 40, passes = 3;  // to either side of the best one so far, each pass within the last one's step
  const Eigen::Index rows = found.r.size();
  const Eigen::Map<const VectorXd> force(measured.data(), rows);
  const VectorXd simulated = force + found.r;
  VectorXd best = found.r, best_step = VectorXd::Zero(found.J.cols());
  double best_shift = 0, reach = most_share * (at.back() - at.front());
  for (int pass = 0; pass < passes; ++pass, reach /= tries) {
    const double middle = best_shift;
    for (int k = -tries; k <= tries; ++k) {
      const double shift = middle + reach * k / tries;
      VectorXd moved(rows);
      MatrixXd J = MatrixXd::Zero(rows, found.J.cols());
      Eigen::Index known = 0;                          // deeper than the deepest nothing is
      for (Eigen::Index row = 0; row < rows; ++row) {  // straight on before the first, where it only pushes
        const double depth = at[static_cast<std::size_t>(row)] + shift;
        if (depth > at.back()) break;
        ++known;
        const Eigen::Index end = std::upper_bound(at.begin() + 1, at.end() - 1, depth) - at.begin();
        const double from = at[static_cast<std::size_t>(end - 1)], way = at[static_cast<std::size_t>(end)] - from,
                     share = way > 0 ? (depth - from) / way : 0;
        moved[row] = std::max(0.0, (1 - share) * simulated[end - 1] + share * simulated[end]);
        if (moved[row] > 0) J.row(row) = (1 - share) * found.J.row(end - 1) + share * found.J.row(end);
      }
      if (2 * known < rows) continue;
      const VectorXd apart = (moved - force).head(known), step = J.topRows(known).colPivHouseholderQr().solve(-apart);
      const VectorXd r = apart + J.topRows(known) * step;
      const bool better =
          r.squaredNorm() / static_cast<double>(known) < best.squaredNorm() / static_cast<double>(best.size());
      if (step.allFinite() && better) best = r, best_step = step, best_shift = shift;
    }
  }
  if (best_shift == 0 || structureOf(best) > little_left * found.structure) return 0;
  widenTo(best_step, sought, found);
  return -best_shift;
}

void widenToHalves(const std::vector<SoughtParameter>& sought, Identified& found) {
  const Eigen::Index half = found.r.size() / 2;
  widenTo(stepFor(found.J.topRows(half), found.r.head(half)), sought, found);
  widenTo(stepFor(found.J.bottomRows(half), found.r.tail(half)), sought, found);
}

}  // namespace palpate::tools

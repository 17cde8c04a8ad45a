#include "mtled/identify/coarse_to_fine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/input_error.h"

namespace palpate::tools {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int max_fine_solves = 6;
// The search stays where it is: its way is below this share of the interval's half, or of a coordinate.
constexpr double share_of_interval = 0.1, share_of_coordinate = 1e-3;
constexpr double least_felt = 1e-4;  // of what was measured, by a change of one in a coordinate

VectorXd vectorOf(const std::vector<double>& a) {
  return Eigen::Map<const VectorXd>(a.data(), static_cast<Eigen::Index>(a.size()));
}

/// identify() from an answer.
Identified leastSquares(const std::vector<SoughtParameter>& sought, const VectorXd& measured,
                        const std::function<VectorXd(const std::vector<double>&)>& answer) {
  return identify(sought, [&](const std::vector<double>& values) {
    const VectorXd r = answer(values) - measured;
    return std::vector<double>(r.begin(), r.end());
  });
}

/// Whether going from `start` to what was found is no way any more.
bool stays(const std::vector<SoughtParameter>& sought, const Identified& found) {
  for (std::size_t k = 0; k < sought.size(); ++k) {
    const Coordinate coordinate(sought[k]);
    const double half = 0.5 * (coordinate.from(found.high[k]) - coordinate.from(found.low[k]));
    const double way = std::abs(coordinate.from(found.value[k]) - coordinate.from(sought[k].start));
    if (way > std::max(share_of_interval * half, share_of_coordinate)) return false;
  }
  return true;
}

}  // namespace

CoarseToFine identifyCoarseToFine(const std::vector<SoughtParameter>& sought, const std::vector<double>& measured,
                                  const Answer& coarse, const Answer& fine) {
  const VectorXd target = vectorOf(measured);
  CoarseToFine result;
  std::map<std::vector<double>, VectorXd> known;
  const auto coarseAt = [&](const std::vector<double>& values) {
    const auto [answer, is_new] = known.try_emplace(values);
    if (is_new) {
      answer->second = vectorOf(coarse(values));
      ++result.coarse_solves;
    }
    return answer->second;
  };
  try {
    result.found = leastSquares(sought, target, coarseAt);
  } catch (const InputError&) {  // of what was measured
    throw;
  } catch (const std::runtime_error& error) {
    throw CoarseFailed(error.what());
  }
  if (result.found.J.colwise().norm().minCoeff() < least_felt * target.norm())
    throw CoarseFailed("the coarse answers do not depend on a parameter");
  std::vector<SoughtParameter> from = sought;
  MatrixXd S;
  VectorXd f, c, f_before, c_before;
  for (bool arrived = false; !arrived;) {
    for (std::size_t k = 0; k < sought.size(); ++k) from[k].start = result.found.value[k];
    f = vectorOf(fine(result.found.value));
    c = coarseAt(result.found.value);
    ++result.fine_solves;
    if (result.fine_solves == 1) {
      S = f.norm() / c.norm() * MatrixXd::Identity(f.size(), f.size());
    } else {
      const VectorXd way = c - c_before;
      if (way.squaredNorm() > 0) S += (f - f_before - S * way) * way.transpose() / way.squaredNorm();
    }
    f_before = f;
    c_before = c;
    result.found = leastSquares(
        from, target, [&](const std::vector<double>& values) { return VectorXd(f + S * (coarseAt(values) - c)); });
    arrived = stays(from, result.found);
    if (!arrived && result.fine_solves == max_fine_solves) {
      result.found.converged = false;
      break;
    }
  }
  return result;
}

CoarseToFine identifyFine(const std::vector<SoughtParameter>& sought, const std::vector<double>& measured,
                          const Answer& fine) {
  CoarseToFine result;
  result.found = leastSquares(sought, vectorOf(measured), [&](const std::vector<double>& values) {
    ++result.fine_solves;
    return vectorOf(fine(values));
  });
  return result;
}

}  // namespace palpate::tools

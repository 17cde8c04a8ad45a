#include "discretization/cells/adaptive_quadrature.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <string>

#include "base/input_error.h"
#include "base/parallel_for.h"
#include "discretization/cells/cell_division.h"

namespace palpate {
namespace {

/// A difference of integrals below this share of the integral of |f| is rounding.
constexpr double rounding = 1e-14;
/// log2 of the smallest share of a cell: edges of 1/64.
constexpr int max_halvings = 18;

int log2OfDivision(int division) { return division == 2 ? 1 : division == 4 ? 2 : 3; }

void check(const AdaptiveOptions& o) {
  if (!(o.accuracy > 0)) {
    throw InputError({}, "the accuracy of the adaptive quadrature, " + std::to_string(o.accuracy) + ", is not positive",
                     "give a relative error such as 0.1");
  }
  if (o.division != 2 && o.division != 4 && o.division != 8) {
    throw InputError({}, "a cell can't be divided into " + std::to_string(o.division), "use 2, 4 or 8");
  }
  const int deepest = max_halvings / log2OfDivision(o.division);
  if (o.max_depth < 0 || o.max_depth > deepest) {
    throw InputError({},
                     "a depth of " + std::to_string(o.max_depth) + " divisions into " + std::to_string(o.division) +
                         " is out of range",
                     "use 0 to " + std::to_string(deepest));
  }
}

/// A part of a cell and the rule's integrals over it.
struct Part {
  Corners corners;
  double volume = 0;
  Vec3 integral = Vec3::Zero();
  Vec3 magnitude = Vec3::Zero();  // the same of |f|, with the rule's weights taken positive
};

/// Refines cells one after another; one per thread.
class Refinement {
 public:
  Refinement(const AdaptiveOptions& options, const CellRule& rule, const Integrand& f)
      : options_(options), rule_(rule), f_(f) {}

  AdaptivePoints cell(const Corners& corners, double volume, int cell) {
    result_ = {};
    cell_ = cell;
    refine(estimate(corners, volume), 0);
    result_.divided_cells = result_.deepest > 0;
    return std::move(result_);
  }

 private:
  Part estimate(const Corners& corners, double volume) {
    Part part{corners, volume};
    sample_ = {};
    rule_.append(corners, volume, cell_, sample_);
    for (std::size_t q = 0; q < sample_.X.size(); ++q) {
      const Vec3 value = f_(sample_.X[q]);
      if (!value.allFinite()) result_.not_finite.push_back(sample_.X[q]);
      part.integral += sample_.volume[q] * value;
      part.magnitude += std::abs(sample_.volume[q]) * value.cwiseAbs();
    }
    return part;
  }

  void refine(const Part& parent, int depth) {
    result_.deepest = std::max(result_.deepest, depth);
    std::array<Corners, 8> corners;
    divideCell(parent.corners, options_.division, depth, corners);
    std::array<Part, 8> parts;
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < options_.division; ++i) {
      parts[i] = estimate(corners[i], parent.volume / options_.division);
      sum += parts[i].integral;
    }
    const bool judged = parent.integral.allFinite() && sum.allFinite();
    const double error = judged ? relativeError(parent, sum) : 0;
    if (error > options_.accuracy && depth < options_.max_depth) {
      for (int i = 0; i < options_.division; ++i) refine(parts[i], depth + 1);
      return;
    }
    if (error > options_.accuracy) ++result_.limited_cells;
    result_.worst_error = std::max(result_.worst_error, error);
    rule_.append(parent.corners, parent.volume, cell_, result_.points);
  }

  static double relativeError(const Part& parent, const Vec3& sum) {
    double error = 0;
    for (int c = 0; c < 3; ++c) {
      const double difference = std::abs(parent.integral[c] - sum[c]);
      if (difference > rounding * parent.magnitude[c])
        error = std::max(error, difference / std::abs(parent.integral[c]));
    }
    return error;
  }

  const AdaptiveOptions& options_;
  const CellRule& rule_;
  const Integrand& f_;
  int cell_ = 0;
  AdaptivePoints result_;
  IntegrationPoints sample_;
};

void append(AdaptivePoints& all, const AdaptivePoints& cell) {
  const auto concatenate = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  concatenate(all.points.X, cell.points.X);
  concatenate(all.points.volume, cell.points.volume);
  concatenate(all.points.cell, cell.points.cell);
  concatenate(all.not_finite, cell.not_finite);
  all.divided_cells += cell.divided_cells;
  all.deepest = std::max(all.deepest, cell.deepest);
  all.limited_cells += cell.limited_cells;
  all.worst_error = std::max(all.worst_error, cell.worst_error);
}

}  // namespace

AdaptivePoints makeAdaptivePoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                  const std::vector<double>& cell_volume, const AdaptiveOptions& options,
                                  const Integrand& f) {
  check(options);
  const CellRule rule = cellRule(options.points_per_cell);
  std::vector<AdaptivePoints> of_cell(cells.size());
  std::atomic<long long> count{0};
  parallelFor(static_cast<int>(cells.size()), [&](int begin, int end) {
    const Integrand my_f = f;
    Refinement refinement(options, rule, my_f);
    for (int c = begin; c < end; ++c) {
      const auto& [i, j, k, l] = cells[c];
      of_cell[c] = refinement.cell({X[i], X[j], X[k], X[l]}, cell_volume[c], c);
      count += static_cast<long long>(of_cell[c].points.X.size());
      if (count > options.max_points) {
        throw InputError({},
                         "the adaptive quadrature needs more than " + std::to_string(options.max_points) + " points",
                         "lower its depth or its accuracy");
      }
    }
  });

  AdaptivePoints all;
  for (AdaptivePoints& cell : of_cell) {
    append(all, cell);
    cell = {};
  }
  return all;
}

}  // namespace palpate

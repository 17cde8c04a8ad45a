#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "base/parameter.h"

namespace palpate::tools {

/// A number that is sought, and how it may be.
struct SoughtParameter {
  std::string name;
  ValueRange range;
  double start = 0;
};

/// A parameter as an unbounded coordinate: its logarithm where its range has one end near, the logit where it has two.
/// One that may be anything keeps the sign that it begins with, and has the logarithm of its size; at 0, itself.
class Coordinate {
 public:
  explicit Coordinate(const SoughtParameter& parameter);

  /// A step of one in it is the same share of the value everywhere.
  bool isRelative() const;
  double from(double value) const;
  double to(double q) const;
  double slopeAt(double q) const;  // of to()

 private:
  double low_, high_;
};

/// What fits best.
struct Identified {
  std::vector<double> value, low, high;  // (parameter_count) with the ends of the 95 % confidence interval
  double misfit = 0;                     // root mean square of the residuals, in their unit
  double structure = 0;                  // of it, what follows from row to row and so is no noise; 0: none is told
  bool converged = false;
  bool told_apart = true;  // false: other values together fit as well, and the intervals say little

  // At these values.
  Eigen::MatrixXd J;  // (row_count, parameter_count) change of the residuals with the coordinates
  Eigen::VectorXd r;  // (row_count) residuals
};

/// Least squares by Levenberg and Marquardt (Marquardt, SIAM J. Appl. Math. 11, 431 (1963)) over unbounded coordinates.
/// Derivatives are differences, unless they are given. The intervals come from (J^T J)^-1 and the residuals, in those
/// coordinates, with Student's t; they allow for noise that grows with the force and for residuals that follow their
/// neighbours, and hold what they say where the residuals are noise.
/// @param residuals    r(values), always as many; may throw std::runtime_error for values that can't be
/// @param derivatives  dr/dvalues (row_count)(parameter_count)
Identified identify(
    const std::vector<SoughtParameter>& sought,
    const std::function<std::vector<double>(const std::vector<double>&)>& residuals,
    const std::function<std::vector<std::vector<double>>(const std::vector<double>&)>& derivatives = {});

/// Widens the intervals to the values that would fit if what was measured were another by `change` (row_count), to
/// first order.
void widenFor(const std::vector<double>& change, const std::vector<SoughtParameter>& sought, Identified& found);

/// Widens the intervals to what fits if the simulated forces are off by a share of themselves, either way, to first
/// order. @param measured  N (row_count)
void widenForError(double share, const std::vector<double>& measured, const std::vector<SoughtParameter>& sought,
                   Identified& found);

/// The same for a share that is larger where less of the tool touches, as (largest force / force)^(1/3), which is the
/// contact's radius over the largest (Hertz): what only the shape of a curve tells, as Poisson's ratio, is no surer.
void widenForErrorAlong(double share, const std::vector<double>& measured, const std::vector<SoughtParameter>& sought,
                        Identified& found);

/// Of a curve's residuals, simulated less measured: where depths that counted from another place than the touch leave
/// little of what follows from row to row, widens the intervals to the values that would fit then.
/// @param at, measured  depth, m, ascending, and force, N (row_count)
/// @return m, by which the depths are too large; 0: that is not it
double widenForShift(const std::vector<double>& at, const std::vector<double>& measured,
                     const std::vector<SoughtParameter>& sought, Identified& found);

/// Where a number times `column` (row_count) is more than half of the residuals, or of what follows from row to row in
/// them: widens the intervals to the values that would fit without. @return the number; 0: that is not it
double widenForOffset(const std::vector<double>& column, const std::vector<SoughtParameter>& sought, Identified& found);

/// Widens the intervals to the values that each half of the rows would give alone, to first order: where the residuals
/// are no noise, the parameters are none, either.
void widenToHalves(const std::vector<SoughtParameter>& sought, Identified& found);

}  // namespace palpate::tools

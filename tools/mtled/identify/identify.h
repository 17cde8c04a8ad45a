#pragma once

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

/// What fits best.
struct Identified {
  std::vector<double> value, low, high;  // (parameter_count) with the ends of the 95 % confidence interval
  double misfit = 0;                     // root mean square of the residuals, in their unit
  int evaluations = 0;
  bool converged = false;
  bool told_apart = true;  // false: other values together fit as well, and the intervals say little
};

/// Least squares by Levenberg and Marquardt (Marquardt, SIAM J. Appl. Math. 11, 431 (1963)) over unbounded coordinates:
/// the logarithm where a range has one end near, the logit where it has two. Derivatives are differences. The intervals
/// come from (J^T J)^-1 and the residuals, in those coordinates, with Student's t; they allow for noise that grows with
/// the force and for residuals that follow their neighbours, and hold what they say where the residuals are noise.
/// @param residuals  r(values), always as many; may throw std::runtime_error for values that can't be
Identified identify(const std::vector<SoughtParameter>& sought,
                    const std::function<std::vector<double>(const std::vector<double>&)>& residuals);

}  // namespace palpate::tools

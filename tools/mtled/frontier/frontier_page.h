#pragma once

#include <string>

#include "mtled/frontier/frontier_result.h"

namespace palpate::tools {

/// What uniform nodes would cost at a force error: by the power law that fits the rows of groups "present" and
/// "spacing" best (least
/// squares of logarithms). us per millisecond of physics; NaN where there are fewer than two such rows, or finer
/// ones are not dearer.
double uniformCostAt(const Frontier& frontier, double force_error);

/// Writes README.md (tables of all settings, the picture with the Pareto front, what refinement buys), frontier.png
/// and results.json
/// into a folder. @param command  that repeats it
void writeFrontierPage(const std::string& folder, const std::string& command, const Frontier& frontier);

}  // namespace palpate::tools

#pragma once

#include <string>
#include <vector>

#include "simulation/model.h"

namespace palpate::tools {

/// Force on a tool over its travel past first touch, while it is pressed in.
struct ForceCurve {
  std::vector<double> depth;  // m, ascending, above 0
  std::vector<double> force;  // N, its size

  double deepest() const { return depth.back(); }
};

/// Reads a measured curve: a CSV file with the columns depth_m and force_N, or a run's force.csv (advance_m, else
/// depth_m, and force_raw_N_x, _y, _z). Rows up to the deepest, without those before touch; of rows at the same depth
/// the mean. Throws InputError where less than five are left.
ForceCurve readForceCurve(const std::string& path);

/// The model's: its tool pressed along its axis to `deepest` m at an even speed, in `seconds` of physics time, which
/// should be long against the tissue's own swinging. A point for each tick; from them forceAt interpolates.
/// Throws std::runtime_error where the solution can't be trusted on the way.
ForceCurve simulateForceCurve(const Model& model, double deepest, double seconds);

/// N; linear between points, from 0 at touch.
double forceAt(const ForceCurve& curve, double depth);

}  // namespace palpate::tools

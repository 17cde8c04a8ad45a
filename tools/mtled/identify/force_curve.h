#pragma once

#include <string>
#include <vector>

#include "model/model.h"
#include "step/trust.h"

namespace palpate::tools {

/// Force on a tool over its travel past first touch, while it is pressed in.
struct ForceCurve {
  std::vector<double> depth;  // m, ascending, above 0
  std::vector<double> force;  // N, its size
  RunTrust trust;             // of a simulated one

  double deepest() const { return depth.back(); }
};

/// A measured one, and what the rows after the way in tell of whether it had settled.
struct MeasuredCurve : ForceCurve {
  double seconds = 0;  // from touch to the deepest row; 0: the file has no times
  /// (row_count) N, how far the force came to lie from that on the way in (below it: negative), while the tool was held
  /// or on its way out. Empty where the file has neither.
  std::vector<double> change;
};

/// Reads a measured curve: a CSV file with the columns depth_m (or depth_mm) and force_N (or force_mN), or a run's
/// force.csv (advance_m, and force_raw_N_x, _y, _z); time_s may stand beside them. Rows in the order of time, up to the
/// deepest, without those before touch; of rows at the same depth the mean. Throws InputError where less than five are
/// left.
MeasuredCurve readForceCurve(const std::string& path);

/// Throws InputError where a curve is deeper than the model is thick along its tool's axis, or its force is further
/// from the model's than any soft tissue is from another: its unit is another one.
/// @param simulated  N, the model's force at the deepest row
void checkUnits(const MeasuredCurve& measured, const std::string& path, const Model& model);
void checkUnits(const MeasuredCurve& measured, const std::string& path, double simulated);

/// The model's: its tool pressed along its axis to `deepest` m at an even speed, in `seconds` of physics time, which
/// should be long against the tissue's own swinging. A point for each tick; from them forceAt interpolates.
/// Throws std::runtime_error where the solution can't be trusted on the way.
/// @param threads  the curve does not depend on it
ForceCurve simulateForceCurve(const Model& model, double deepest, double seconds, int threads = 1);

/// N; linear between points, from 0 at touch.
double forceAt(const ForceCurve& curve, double depth);

}  // namespace palpate::tools

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
  double fall = 0;  // share of the force that went while the tool was held at its deepest; 0: none, or not held
  RunTrust trust;   // of a simulated one

  double deepest() const { return depth.back(); }
};

/// A measured one, and what the rows after the way in tell of whether it had settled.
struct MeasuredCurve : ForceCurve {
  double seconds = 0;       // from touch to the deepest row; 0: the file has no times
  double held_seconds = 0;  // in which the force fell
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

/// Of tissue that relaxes at most so much is simulated, s: of a press, and of a tool that is held.
inline constexpr double longest_press = 100;

/// How a tool is pressed in.
struct PressWay {
  double deepest = 0;       // m past touch
  double seconds = 0;       // of physics time, at an even speed; long against the tissue's own swinging
  double held_seconds = 0;  // at its deepest, after that
};

/// The model's: its tool pressed along its axis. A point for each tick; from them forceAt interpolates.
/// Throws std::runtime_error where the solution can't be trusted on the way.
/// @param threads  the curve does not depend on it
ForceCurve simulateForceCurve(const Model& model, const PressWay& way, int threads = 1);

/// N; linear between points, from 0 at touch.
double forceAt(const ForceCurve& curve, double depth);

}  // namespace palpate::tools

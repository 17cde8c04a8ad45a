#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/converged_run.h"

namespace palpate {

/// A kind of setting whose spacing is then searched.
struct FitFamily {
  std::string name;
  std::function<void(Scene&)> turn;
};
std::vector<FitFamily> fitFamilies(const Scene& scene);

/// A setting that has the time it needs.
struct FitCandidate {
  std::string family;
  Scene scene;
  double spacing_factor = 1;   // times the given scene's spacing
  int nodes = 0, points = 0, substeps = 0;
  RunCost cost;
  ScriptedRun run;
  RunError error;              // against the converged run
  double expected_error = 0;   // of the force, against the truth
};

struct FitTask {
  const Scene& scene;          // as given, with the rate and threads asked for
  const ToolWay& way;
  const std::vector<Vec3>& probes;
  int threads = 1;
  std::function<void(double, const std::string&)> watch;
};

/// The finest spacing of a family whose median tick takes at most `share` of its time. Empty spacing_factor 0: none does
/// down to a few hundred nodes.
FitCandidate finestWithin(const FitTask& task, const FitFamily& family, double share);

/// What a candidate of `factor` times the scene's spacing is compared with.
Fineness fitFineness(double factor);

/// The force error to expect: the distance from the reference and what the reference itself lacks. A solution that converges with
/// the square of the spacing is 1 / (r^2 - 1) of its distance from one r times as coarse away from the limit.
double expectedError(const RunError& error, const ConvergedRun& converged, double coarser);

}  // namespace palpate

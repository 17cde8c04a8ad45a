#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mtled/fit/fit_record.h"
#include "mtled/run/converged_run.h"

namespace palpate::tools {

/// A kind of setting whose spacing is then searched.
struct FitFamily {
  std::string name;
  std::function<void(Scene&)> turn;
  double inside = 1;  // spacing where the tool works, as a share of that elsewhere
};
/// @param places  where refinement is worth it; without: the spacing is the same everywhere
std::vector<FitFamily> fitFamilies(const Scene& scene, const std::vector<ContactRegion>& places);

/// A setting that was tried, with its scene.
struct FitCandidate : FitTry {
  double inside = 1;  // of its family
  Scene scene;
  RunError error;     // against the converged run
  RunError expected;  // of the force, against the truth
};

struct FitTask {
  const Scene& scene;  // as given, with the rate and threads asked for
  const ToolTrajectory& way;
  const std::vector<Vec3>& probes;
  int threads = 1;
  FitRecord& record;  // knows what was tried already
  std::function<void(double, const std::string&)> watch;
};

/// The family at so many times the scene's spacing: run, or found in the record.
FitCandidate tried(const FitTask& task, const FitFamily& family, double spacing_factor);

/// The finest spacing of a family whose median tick takes at most `share` of its time. Its spacing_factor is 0 where
/// none does
/// down to a few hundred nodes, or the search was interrupted.
/// @param start  spacing factor to begin with
FitCandidate finestWithin(const FitTask& task, const FitFamily& family, double share, double start = 1);

/// What candidates are compared with.
/// @param outside, inside  finest spacing of any of them elsewhere and where the tool works, times the scene's
Fineness fitFineness(double outside, double inside);

/// The force errors to expect: the distance from the reference and what the reference itself lacks. A solution that
/// converges with
/// the square of the spacing is 1 / (r^2 - 1) of its distance from one r times as coarse away from the limit. No less
/// than what the reference does not see of a thin layer.
RunError expectedError(const RunError& error, const ConvergedRun& converged, double coarser);

}  // namespace palpate::tools

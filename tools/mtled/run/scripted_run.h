#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/model.h"
#include "model/state.h"

namespace palpate::tools {

/// The tool's way in world coordinates, the same for every discretization of a scene: poses at the end of each tick.
using ToolTrajectory = std::vector<Pose>;

/// Throws InputError for a scene with several tools or jaws: only the first tool's way is gone here.
void checkOneWay(const Scene& scene, const std::string& command);

/// What a scene does when nothing else is asked: the built-in indentation (io/indent_script.h) from just above the
/// skin on, then a quarter of a second at rest.
ToolTrajectory indentationTrajectory(const Model& model);

/// A model's answer to a tool's way, and what it took.
struct ScriptedRun {
  std::vector<Vec3> force;      // (tick_count) N, on the tool, raw, at the end of each tick
  std::vector<Vec3> probe_u;    // (probe_count) m, at the end
  std::vector<double> tick_us;  // (tick_count) computing time of each tick
  float min_J = 1;
  std::uint32_t flags = 0;   // StepFlag, of all ticks
  bool interrupted = false;  // by a signal; what there is ends there

  /// Neither blown up nor with inverted points: an answer that may be compared.
  bool sound() const;
};

/// @param probes      m, points of the body at rest at which displacements are wanted
/// @param in_double   the batch body in double instead of the real-time step in float32
/// Throws std::runtime_error where a probe lies outside the body.
ScriptedRun runTrajectory(const Model& model, const ToolTrajectory& way, const std::vector<Vec3>& probes, int threads,
                          bool in_double = false);

/// m, of the body at the probes (probe_count). Throws as runTrajectory.
std::vector<Vec3> displacementAt(const Model& model, const std::vector<Vec3>& probes, const State& state);

/// How far a run is from a better one of the same way.
struct RunError {
  double force =
      0;  // root mean square of the difference over the ticks with contact in `better`, over its largest force
  double displacement = 0;  // root mean square over the probes at the end, over the largest there
};
RunError errorOf(const ScriptedRun& run, const ScriptedRun& better);

/// Computing time of a run, us: mean per millisecond of physics, median and 99.9th percentile of a tick.
struct RunCost {
  double us_per_ms = 0, tick_p50 = 0, tick_p999 = 0;
};
RunCost costOf(const ScriptedRun& run, double rate_hz);

}  // namespace palpate::tools

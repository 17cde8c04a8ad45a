#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/tool_script.h"
#include "model/model.h"
#include "model/state.h"
#include "step/workspace.h"

namespace palpate::tools {

/// The tools' ways in world coordinates, the same for every discretization of a scene: where they are at the end of
/// each tick.
using ToolTrajectory = std::vector<ToolPostures>;

/// What a scene's tools do: the first as `script` says, or its own, or the built-in indentation (io/indent_script.h)
/// and then a quarter of a second at rest; the others as theirs. A scene's one tool begins just above the skin.
ToolTrajectory scriptedTrajectory(const Model& model, const std::optional<ToolScript>& script = {});

/// The first tool's way; the others stand where they start.
ToolTrajectory othersStand(const std::vector<ToolPosture>& first, const Model& model);

/// A model's answer to its tools' ways, and what it took.
struct ScriptedRun {
  std::vector<Vec3>
      force;  // (tick_count x per tool its force, of jaws also (pinch, 0, 0)) N, raw, at the end of a tick
  std::vector<Vec3> probe_u;    // (probe_count) m, at the end
  std::vector<double> tick_us;  // (tick_count) computing time of each tick
  float min_J = 1;
  std::uint32_t flags = 0;   // StepFlag, of all ticks
  bool interrupted = false;  // by a signal; what there is ends there

  /// Neither blown up nor with inverted points: an answer that may be compared.
  bool sound() const;
  double peakForce() const;  // N
  /// Adds what a tick came to.
  void add(const Model& model, const ToolLoads& loads, std::uint32_t flags, double min_J);
};

/// A model's state, stepped along a way.
struct SteppedTissue {
  SteppedTissue(const Model& of, State from, int threads = 1)
      : model(of), state(std::move(from)), workspace(of, threads) {}

  StepReport tickTo(const ToolPostures& tools);

  const Model& model;
  State state;
  Workspace workspace;
};

/// At rest, the tools being there.
State stateAt(const Model& model, const ToolPostures& tools);

/// @param probes      m, points of the body at rest at which displacements are wanted
/// @param in_double   the batch body in double instead of the real-time step in float32
/// @param watch       gets the share of the way that is done, each tick of the real-time step
/// Throws std::runtime_error where a probe lies outside the body.
ScriptedRun runTrajectory(const Model& model, const ToolTrajectory& way, const std::vector<Vec3>& probes, int threads,
                          bool in_double = false, const std::function<void(double)>& watch = {});

/// m, of the body at the probes (probe_count). Throws as runTrajectory.
std::vector<Vec3> displacementAt(const Model& model, const std::vector<Vec3>& probes, const State& state);

/// How far a run is from a better one of the same way.
struct RunError {
  double force =
      0;  // root mean square of the difference over the ticks with contact in `better`, over its largest force
  double displacement = 0;  // root mean square over the probes at the end, over the largest there
  double loaded = 0;        // largest |difference| / |force| while the force is at least half of its largest
};
RunError errorOf(const ScriptedRun& run, const ScriptedRun& better);

/// How much forces tremble from tick to tick in the last half of the time that the tools stand at the end of their way,
/// over the largest: a standard deviation, of second differences, so that relaxation does not count. 0: they do not
/// stand there for ten ticks. (Runs that settle: below 3e-4; flat punches pressed beyond their radius, where contact
/// never settles and the force is up to a fifth too large: 0.03.)
double trembleOf(const ScriptedRun& run, const ToolTrajectory& way);
inline constexpr double largest_tremble = 0.003;  // of a force that is to be believed

/// sqrt(sum |computed - reference|^2 / sum |reference|^2)
double relativeL2(const std::vector<Vec3>& computed, const std::vector<Vec3>& reference);

/// Computing time of a run, us: mean per millisecond of physics, median and 99.9th percentile of a tick.
struct RunCost {
  double us_per_ms = 0, tick_p50 = 0, tick_p999 = 0;
};
RunCost costOf(const ScriptedRun& run, double rate_hz);

}  // namespace palpate::tools

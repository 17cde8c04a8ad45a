#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <vector>

#include "batch/static_solver.h"
#include "mechanics/essential_boundary.h"
#include "model/model.h"
#include "model/state.h"
#include "mtled/atlas/atlas_result.h"

namespace palpate::tools {

/// A signal has asked for the end: the cell has no result.
struct AtlasInterrupted : std::runtime_error {
  AtlasInterrupted() : std::runtime_error("interrupted") {}
};

/// What is done to a body in real time. Times are physics time, s.
struct AtlasDrive {
  double seconds = 1;
  double still_from = 0.7;  // nothing moves any more: from here on the energy may not grow, and the end is measured
  std::function<Command(double time)> command;  // at the end of a tick; null: the tool stays where it starts
  /// In the program's loop: the tool follows the command's pose as far as the tissue lets it, and what is lost is put
  /// back. Else the bare step, which ends where it is lost.
  bool yields = false;
  bool put_back = false;                // the tissue was just reset, and the hand may still stand deep
  std::function<void(State&)> disturb;  // of the state at rest, before the first tick, of a bare step; null: nothing
};

/// What the last fifth of the still phase showed, beside AtlasMeasure.
struct AtlasRun {
  AtlasMeasure measure;
  Vec3 tool_force = Vec3::Zero();        // N, mean
  Vec3 early_tool_force = Vec3::Zero();  // N, mean over the still phase's second tenth
  std::vector<Reaction> reaction;        // (boundary_count) mean
  Pose tool;                             // at the end
  std::vector<Vec3> u;                   // (node_count) m, displacement parameters at the end
  bool lost() const { return !std::isnan(measure.lost_at); }
};

/// Runs the real-time step as the program does, with doubtOf and the watchdog looking at each tick, to the end of the
/// drive or to the loss. Throws AtlasInterrupted.
AtlasRun drive(const Model& model, const AtlasDrive& drive);

/// The equilibrium in double under the tool, led from its start to a place (m) in six load steps. Its `converged` is
/// false where there is none.
Equilibrium ledTo(const Model& model, const Vec3& place, double tolerance);

/// Sets what was compared. @return the measure, for a cell to hand on
AtlasMeasure compare(const AtlasRun& run, const std::string& what, double value, double truth, double bound);

}  // namespace palpate::tools

#include "realtime/loop/fold_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulation/trust.h"

namespace palpate {

FoldWatch::FoldWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.rate_hz)), strained_(strained * model.rest_energy) {
  for (const BoundarySpec& boundary : model.scene.boundaries) {
    if (!(boundary.duration > 0)) continue;
    const std::vector<double>& times = boundary.curve.time;
    moved_until_ = std::max({moved_until_, boundary.duration, times.empty() ? 0 : times.back()});
  }
  strained_anyway_ = !model.scene.gravity.isZero(0);
  for (const Material& material : model.materials) strained_anyway_ = strained_anyway_ || material.relaxation_count > 0;
}

/// Nothing touches it, and it does not swing.
bool FoldWatch::standsAlone(const StepReport& report) const {
  if (report.contact_count > 0 || !report.tool_force.isZero(0)) return false;
  for (const ToolLoad& load : report.loads)
    if (load.contact_count > 0) return false;
  return report.kinetic_energy <= calm * report.strain_energy;
}

bool FoldWatch::looksFolded(const StepReport& report, double age) {
  if (!standsAlone(report)) return false;
  const double min_J = report.min_J;
  if (moved_until_ > 0) {
    if (age <= moved_until_) return false;
    memory_.rest_J = std::max(memory_.rest_J, min_J);
    return min_J < smaller * memory_.rest_J;
  }
  return min_J < TrustLimits::min_J || (!strained_anyway_ && report.strain_energy > strained_);
}

bool FoldWatch::update(const StepReport& report, bool pulled, double age) {
  if (pulled || !looksFolded(report, age)) {
    memory_.ticks = 0;
    return false;
  }
  if (memory_.ticks == 0 || report.strain_energy < steady_share * memory_.energy) {
    memory_.energy = report.strain_energy;
    memory_.ticks = 0;
  }
  if (++memory_.ticks < needed_) return false;
  memory_ = {};
  return true;
}

}  // namespace palpate

#include "realtime/loop/fold_watch.h"

#include <cmath>

#include "simulation/trust.h"

namespace palpate {

FoldWatch::FoldWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.rate_hz)), strained_(strained * model.rest_energy) {
  for (const BoundarySpec& boundary : model.scene.boundaries) moved_ = moved_ || boundary.duration > 0;
  strained_anyway_ = !model.scene.gravity.isZero(0);
  for (const Material& material : model.materials) strained_anyway_ = strained_anyway_ || material.relaxation_count > 0;
}

bool FoldWatch::looksFolded(const StepReport& report) const {
  if (moved_ || report.contact_count > 0 || !report.tool_force.isZero(0)) return false;
  for (const ToolLoad& load : report.loads)
    if (load.contact_count > 0) return false;
  if (report.kinetic_energy > calm * report.strain_energy) return false;
  return report.min_J < TrustLimits::min_J || (!strained_anyway_ && report.strain_energy > strained_);
}

bool FoldWatch::update(const StepReport& report, bool pulled) {
  if (pulled || !looksFolded(report)) {
    memory_.ticks = 0;
    return false;
  }
  if (memory_.ticks == 0 || report.strain_energy < steady_share * memory_.energy) {
    memory_.energy = report.strain_energy;
    memory_.ticks = 0;
  }
  if (++memory_.ticks < needed_) return false;
  memory_.ticks = 0;
  return true;
}

}  // namespace palpate

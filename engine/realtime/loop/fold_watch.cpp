#include "realtime/loop/fold_watch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "step/trust.h"

namespace palpate {

FoldWatch::FoldWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.dynamics.rate_hz)),
      crushed_needed_(std::llround(crushed_seconds * model.scene.dynamics.rate_hz)),
      strained_(strained * model.rest_energy),
      moved_until_(motionEnd(model.scene)) {
  strained_anyway_ = !model.scene.dynamics.gravity.isZero(0);
  for (const RigidSpec& body : model.scene.rigid) strained_anyway_ = strained_anyway_ || !body.encloses;
  for (const Material& material : model.materials) strained_anyway_ = strained_anyway_ || material.relaxation_count > 0;
}

/// Of tissue that nothing touches. @param stands  it does not swing
bool FoldWatch::isCrushed(const StepReport& report, bool stands, double age) {
  const double min_J = report.min_J;
  if (moved_until_ == 0) return min_J < TrustLimits::min_J;
  if (age <= moved_until_) return false;
  if (stands) memory_.rest_J = std::max(memory_.rest_J, min_J);
  return min_J < smaller * memory_.rest_J;
}

/// Another tick in which the strain energy should stay what it is. @return whether it has for `needed` ticks
bool FoldWatch::Stay::update(double strain_energy, double share, std::int64_t needed) {
  if (ticks == 0 || strain_energy < share * energy) {
    energy = strain_energy;
    ticks = 0;
  }
  return ++ticks >= needed;
}

bool FoldWatch::update(const StepReport& report, bool pulled, double age) {
  if (pulled || report.isTouched()) {
    memory_.still = memory_.crushed = {};
    return false;
  }
  const double energy = report.strain_energy;
  const bool stands = report.kinetic_energy <= calm * energy;
  const bool crushed = isCrushed(report, stands, age);
  const bool loaded = moved_until_ == 0 && !strained_anyway_ && energy > strained_;
  if (!stands || !(crushed || loaded)) memory_.still = {};
  if (!crushed) memory_.crushed = {};
  const bool folded = (stands && (crushed || loaded) && memory_.still.update(energy, steady_share, needed_)) ||
                      (crushed && memory_.crushed.update(energy, crushed_share, crushed_needed_));
  if (folded) memory_ = {};
  return folded;
}

}  // namespace palpate

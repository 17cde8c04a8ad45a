#include "realtime/loop/slide_watch.h"

#include <cmath>

#include "simulation/free_axes.h"

namespace palpate {

SlideWatch::SlideWatch(const Model& model)
    : needed_(std::llround(seconds * model.scene.rate_hz)), free_(freeAxes(model)) {
  Vec3 low = model.X.front(), high = low;
  for (const Vec3& X : model.X) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  far_ = away * (high - low).norm();
}

bool SlideWatch::update(const State& state, const StepReport& report, bool pulled) {
  if (free_.isZero(0)) return false;
  // What slides, slides as a whole: any node tells.
  const bool is_away = toVec3(state.u.front()).cwiseProduct(free_).norm() > far_;
  memory_.ticks = is_away && !pulled && !report.isTouched() ? memory_.ticks + 1 : 0;
  if (memory_.ticks < needed_) return false;
  memory_ = {};
  return true;
}

}  // namespace palpate

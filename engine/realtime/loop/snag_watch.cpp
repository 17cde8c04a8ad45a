#include "realtime/loop/snag_watch.h"

#include <cmath>

#include "contact/tools/tool_list.h"
#include "setup/free_axes.h"
#include "step/tool_contact.h"

namespace palpate {

SnagWatch::SnagWatch(const Model& model, int tool)
    : model_(model),
      tool_(static_cast<std::size_t>(tool)),
      off_(model.tools.tool[tool_].jaws || motionEnd(model.scene) > 0),
      free_(freeAxes(model)),
      low_(model.tools.tool[tool_].start.pose.position),  // where it begins it is never far outside
      high_(low_),
      still_(stands * model.tools.tool[tool_].shape.radius),
      carried_needed_(std::llround(seconds * model.scene.rate_hz)),
      stuck_needed_(std::llround(stuck_seconds * model.scene.rate_hz)) {
  for (const Vec3& X : model.skin.surface.vertices) {
    low_ = low_.cwiseMin(X);
    high_ = high_.cwiseMax(X);
  }
  const ToolShape& shape = model.tools.tool[tool_].shape;  // whose side may touch while its tip is beyond the body
  near_ = 2 * shape.radius + (shape.kind == ToolKind::Sphere ? 0 : shape.length);
  far_ = near_ + far_outside * (high_ - low_).norm();
}

bool SnagWatch::isBeyond(const State& state, const Vec3& tip, double distance) const {
  const Vec3 at = tip - free_.cwiseProduct(toVec3(state.u.front()));  // what slides, slides as a whole
  return ((at - high_).array() > distance).any() || ((low_ - at).array() > distance).any();
}

/// Whether the contact pushes the tool against going along `way` hardly more than along it.
bool SnagWatch::isBetween(const State& state, const Vec3& way) const {
  double against = 0, along = 0;
  for (std::size_t b = 0; b < model_.tools.body.size(); ++b) {
    if (model_.tools.body[b].tool != static_cast<int>(tool_)) continue;
    forEachContactForce(state.contact[b], [&](int, const Float4& on_tissue) {
      const double f = way.dot(toVec3(on_tissue));
      (f > 0 ? against : along) += std::abs(f);
    });
  }
  return against - along < between * (against + along);
}

bool SnagWatch::isCarrying(const State& state, const Vec3& hand, bool touches) {
  if (!isBeyond(state, state.tool[tool_].pose.position, near_) || !isBeyond(state, hand, far_))
    memory_.carried_ticks = 0;
  else if (touches)  // a fold that swings touches now and then
    ++memory_.carried_ticks;
  return memory_.carried_ticks >= carried_needed_;
}

bool SnagWatch::isStuck(const State& state, const Vec3& hand, bool touches) {
  const Vec3& tip = state.tool[tool_].pose.position;
  const bool stays = memory_.stuck_ticks > 0 && (tip - memory_.stood_at).norm() <= still_;
  if (!touches || !isBeyond(state, hand, far_) || !isBetween(state, hand - tip)) {
    memory_.stuck_ticks = 0;
    return false;
  }
  if (!stays) memory_.stood_at = tip;
  memory_.stuck_ticks = stays ? memory_.stuck_ticks + 1 : 1;
  return memory_.stuck_ticks >= stuck_needed_;
}

bool SnagWatch::update(const State& state, const Vec3& hand, const StepReport& last) {
  if (off_) return false;
  const bool touches = last.loads[tool_].contact_count > 0;
  const bool carries = isCarrying(state, hand, touches);
  if (!isStuck(state, hand, touches) && !carries) return false;
  memory_ = {};
  return true;
}

bool SnagWatch::isClear(const State& state, const StepReport& last) const {
  return isBeyond(state, state.tool[tool_].pose.position, near_) && last.loads[tool_].near_count == 0;
}

}  // namespace palpate

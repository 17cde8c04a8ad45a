#include "realtime/loop/snag_watch.h"

#include <algorithm>
#include <cmath>

#include "contact/tools/tool_list.h"
#include "setup/free_axes.h"
#include "step/tool_contact.h"

namespace palpate {
namespace {

/// Whether the contact pushes the tool against going along `way` hardly more than along it.
bool isBetween(const State& state, const Vec3& way) {
  double against = 0, along = 0;
  forEachContactForce(state.contact[0], [&](int, const Float4& on_tissue) {
    const double f = way.dot(toVec3(on_tissue));
    (f > 0 ? against : along) += std::abs(f);
  });
  return against - along < SnagWatch::between * (against + along);
}

bool isHeldByFurther(const StepReport& report) {
  return std::any_of(report.loads.begin() + 1, report.loads.end(),
                     [](const ToolLoad& load) { return load.contact_count > 0; });
}

}  // namespace

SnagWatch::SnagWatch(const Model& model)
    : free_(freeAxes(model)),
      still_(stands * model.scene.tools[0].shape.radius),
      carried_needed_(std::llround(seconds * model.scene.rate_hz)),
      stuck_needed_(std::llround(stuck_seconds * model.scene.rate_hz)) {
  for (const ToolSetUp& tool : model.tools.tool) off_ = off_ || tool.jaws;
  off_ = off_ || motionEnd(model.scene) > 0;
  low_ = high_ = model.tools.first().start.pose.position;  // where it begins it is never far outside
  for (const Vec3& X : model.skin.surface.vertices) {
    low_ = low_.cwiseMin(X);
    high_ = high_.cwiseMax(X);
  }
  const ToolShape& tool = model.scene.tools[0].shape;  // whose side may touch while its tip is beyond the body
  near_ = 2 * tool.radius + (tool.kind == ToolKind::Sphere ? 0 : tool.length);
  far_ = near_ + far_outside * (high_ - low_).norm();
}

bool SnagWatch::isBeyond(const State& state, const Vec3& tip, double distance) const {
  const Vec3 at = tip - free_.cwiseProduct(toVec3(state.u.front()));  // what slides, slides as a whole
  return ((at - high_).array() > distance).any() || ((low_ - at).array() > distance).any();
}

bool SnagWatch::isCarrying(const State& state, const Vec3& hand, const StepReport& report) {
  if (!isBeyond(state, state.tool[0].pose.position, near_) || !isBeyond(state, hand, far_))
    memory_.carried_ticks = 0;
  else if (report.contact_count > 0)  // a fold that swings touches now and then
    ++memory_.carried_ticks;
  return memory_.carried_ticks >= carried_needed_;
}

bool SnagWatch::isStuck(const State& state, const Vec3& hand, const StepReport& report) {
  const Vec3& tip = state.tool[0].pose.position;
  const bool stays = memory_.stuck_ticks > 0 && (tip - memory_.stood_at).norm() <= still_;
  if (!isBeyond(state, hand, far_) || report.contact_count == 0 || !isBetween(state, hand - tip)) {
    memory_.stuck_ticks = 0;
    return false;
  }
  if (!stays) memory_.stood_at = tip;
  memory_.stuck_ticks = stays ? memory_.stuck_ticks + 1 : 1;
  return memory_.stuck_ticks >= stuck_needed_;
}

bool SnagWatch::update(const State& state, const Vec3& hand, const StepReport& report) {
  if (off_) return false;
  if (isHeldByFurther(report)) {
    memory_ = {};
    return false;
  }
  const bool carries = isCarrying(state, hand, report);
  if (!isStuck(state, hand, report) && !carries) return false;
  memory_ = {};
  return true;
}

}  // namespace palpate

#include "realtime/loop/snag_watch.h"

#include <cmath>

#include "step/tool_contact.h"

namespace palpate {

SnagWatch::SnagWatch(const Model& model, int tool)
    : model_(model),
      tool_(static_cast<std::size_t>(tool)),
      still_(stands * model.tools.tool[tool_].shape.radius),
      needed_(std::llround(seconds * model.scene.dynamics.rate_hz)) {
  far_ = far * boxOf(model.skin.surface.vertices).sizes().norm();
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
  return against + along > 0 && against - along < between * (against + along);
}

bool SnagWatch::update(const State& state, const Vec3& hand) {
  const Vec3& tip = state.tool[tool_].pose.position;
  const Vec3 way = hand - tip;
  if (model_.tools.tool[tool_].jaws || way.norm() <= far_ || !isBetween(state, way)) {
    memory_ = {};
    return false;
  }
  if (memory_.ticks == 0 || (tip - memory_.stood_at).norm() > still_) memory_ = {0, tip};
  if (++memory_.ticks < needed_) return false;
  memory_ = {};
  return true;
}

}  // namespace palpate

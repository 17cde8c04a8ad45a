#include "realtime/loop/snag_watch.h"

#include <algorithm>
#include <cmath>

#include "contact/tools/tool_list.h"

namespace palpate {

SnagWatch::SnagWatch(const Model& model)
    : off_(!model.tools.empty()), needed_(std::llround(seconds * model.scene.rate_hz)) {
  for (const BoundarySpec& boundary : model.scene.boundaries) off_ = off_ || boundary.duration > 0;
  low_ = high_ = model.tool_start.position;  // where it begins it is never far outside
  for (const Vec3& X : model.skin.surface.vertices) {
    low_ = low_.cwiseMin(X);
    high_ = high_.cwiseMax(X);
  }
  const ToolShape& tool = model.scene.tool;  // whose side may touch while its tip is beyond the body
  near_ = 2 * tool.radius + (tool.kind == ToolKind::Sphere ? 0 : tool.length);
  far_ = near_ + far_outside * (high_ - low_).norm();
}

bool SnagWatch::isBeyond(const Vec3& tip, double distance) const {
  return ((tip - high_).array() > distance).any() || ((low_ - tip).array() > distance).any();
}

bool SnagWatch::update(const State& state, const Vec3& hand, const StepReport& report) {
  if (off_ || !isBeyond(state.tool_pose.position, near_) || !isBeyond(hand, far_))
    ticks_ = 0;
  else if (report.contact_count > 0)  // a fold that swings touches now and then
    ++ticks_;
  if (ticks_ < needed_) return false;
  ticks_ = 0;
  return true;
}

}  // namespace palpate

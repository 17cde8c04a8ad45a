#include "setup/make_tools.h"

#include <algorithm>
#include <cmath>

#include "base/input_error.h"
#include "base/turn.h"
#include "contact/contact.h"

namespace palpate {
namespace {

/// m, along the way the tip points, of what touches first; not finite: nothing does.
double travelToSkin(const TriangleSurface& skin, const ToolSet& set, int tool, const ToolPosture& start) {
  double first = std::numeric_limits<double>::infinity();
  for (const ToolBody& body : set.body)
    if (body.tool == tool) first = std::min(first, firstContactTravel(skin, body.shape, bodyPose(body, start)));
  return first;
}

bool startsInside(const SurfaceTree& organ, const ToolSet& set, int tool, const ToolPosture& start) {
  return std::any_of(set.body.begin(), set.body.end(), [&](const ToolBody& body) {
    if (body.tool != tool) return false;
    const Pose pose = bodyPose(body, start);
    return organ.inside(pose.position) || organ.inside(pose.toWorld(Vec3(0, 0, body.shape.radius)));
  });
}

Pose startPose(const ToolSpec& spec) { return {spec.position, uprightOn(-spec.direction)}; }

}  // namespace

ToolSet makeToolSet(const Scene& scene, const SurfaceTree& organ, const TriangleSurface& skin) {
  ToolSet set;
  set.tool.clear(), set.body.clear();
  const std::vector<ToolSpec>& specs = scene.tools;
  for (std::size_t t = 0; t < specs.size(); ++t) {
    const ToolSpec& spec = specs[t];
    const int tool = static_cast<int>(t);
    ToolSetUp made;
    made.shape = spec.shape;
    made.jaws = spec.jaws();
    made.start = {startPose(spec), std::max(0.0, spec.opening)};
    made.max_speed = spec.max_speed;
    made.max_force = spec.max_force;
    made.grip_force = spec.grip_force;
    made.friction = spec.friction;
    if (made.jaws) {
      set.body.push_back({tool, -1, spec.shape});
      set.body.push_back({tool, 1, spec.shape});
    } else {
      set.body.push_back({tool, 0, spec.shape});
    }
    const double travel = travelToSkin(skin, set, tool, made.start);
    if (travel < 0 || startsInside(organ, set, tool, made.start))
      throw InputError(spec.place,
                       specs.size() == 1 ? "the tool starts inside the organ"
                                         : "tool " + std::to_string(t + 1) + " starts inside the organ",
                       made.jaws ? "move its position out of it, let its direction point at it, or widen its opening"
                                 : "move its position out of it, and let its direction point at it");
    made.first_contact_travel = std::isfinite(travel) ? travel : 0;  // never touches: depth counts from the start
    set.tool.push_back(std::move(made));
  }
  return set;
}

}  // namespace palpate

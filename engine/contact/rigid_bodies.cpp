#include "contact/rigid_bodies.h"

#include <algorithm>

namespace palpate {

Pose RigidBody::at(double time) const {
  const double s = motion.curve.at(time, motion.duration);
  const Quat turn(Eigen::AngleAxisd(s * motion.angle, motion.axis));
  return {s * motion.translation + motion.axis_point - turn * motion.axis_point, turn};
}

bool RigidBodies::moves() const {
  return std::any_of(body.begin(), body.end(), [](const RigidBody& b) { return b.motion.moves(); });
}

void addDeepest(const RigidBodies& bodies, const SkinModel& skin, const Float4* u, double time, int first, int stride,
                RigidLoads& loads) {
  for (std::size_t b = 0; b < bodies.body.size(); ++b) {
    const RigidBody& body = bodies.body[b];
    if (body.encloses) continue;
    const Pose pose = body.motion.moves() ? body.at(time) : Pose{};
    double deepest = 0;
    for (int v = first; v < skin.vertexCount(); v += stride) {
      Vec3 normal;
      deepest = std::max(deepest, -body.shape.gapAt(pose.toLocal(skinPosition(skin, v, u)), normal));
    }
    loads[b].max_penetration = std::max(loads[b].max_penetration, deepest);
  }
}

RigidState makeRigidState(const RigidBodies& bodies, int node_count) {
  RigidState state;
  if (bodies.empty()) return state;
  state.force.assign(bodies.vertex.size(), Float4{});
  state.normal.assign(bodies.vertex.size(), Vec3f::Zero());
  state.row.resize(bodies.vertex.size());
  state.near.resize(bodies.vertex.size());
  state.near_u.assign(static_cast<std::size_t>(node_count), Float4{});
  return state;
}

}  // namespace palpate

#include "step/rigid_stop.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "step/tool_bodies.h"

namespace palpate {
namespace {

/// Of the spacing, and of the tool's radius, that a tool keeps from a rigid body: RigidSupport's.
constexpr double kept_share = 0.25;

constexpr int most_walls = 4;  // that it is pushed out of at once

struct Approach {
  double gap = std::numeric_limits<double>::infinity();  // m
  Vec3 out = Vec3::Zero();                               // unit, out of the rigid body
};

/// A rigid body where it is.
struct Obstacle {
  const RigidShape& shape;
  Pose pose;

  Approach at(const Vec3& x) const {
    Vec3 normal;
    const double gap = shape.gapAt(pose.toLocal(x), normal);
    return {gap, pose.orientation * normal.normalized()};
  }
};

/// The nearest of a circle about the tool's axis, and of its middle.
Approach nearestOfCircle(const Obstacle& obstacle, const Vec3& middle, const Vec3& axis, double radius) {
  constexpr int turns = 3;  // to the side that faces the body, from where the middle sees it
  Approach nearest = obstacle.at(middle), seen = nearest;
  for (int k = 0; k < turns && radius > 0; ++k) {
    const Vec3 across = seen.out - seen.out.dot(axis) * axis;
    if (!(across.norm() > 1e-9)) break;
    seen = obstacle.at(middle - radius * across.normalized());
    if (seen.gap < nearest.gap) nearest = seen;
  }
  return nearest;
}

/// The nearest of a tool's body.
Approach nearestOf(const Obstacle& obstacle, const ToolProfile& profile, const Pose& tool) {
  const Vec3 axis = tool.orientation * Vec3::UnitZ();
  Approach nearest;
  const auto look = [&](double r, double z) {
    const Approach at = nearestOfCircle(obstacle, tool.position + z * axis, axis, r);
    if (at.gap < nearest.gap) nearest = at;
  };
  for (int k = 0; k < profile.corner_count; ++k) {
    const auto c = static_cast<std::size_t>(k);
    look(profile.corner[c].r, profile.corner[c].z);
    if (k + 1 == profile.corner_count) break;
    const int pieces = std::max(1, static_cast<int>(std::ceil(profile.side_length[c] / (0.5 * profile.radius))));
    for (int p = 1; p < pieces; ++p) {
      const double share = static_cast<double>(p) / pieces;
      look(profile.corner[c].r + share * (profile.corner[c + 1].r - profile.corner[c].r),
           profile.corner[c].z + share * (profile.corner[c + 1].z - profile.corner[c].z));
    }
  }
  nearest.gap -= profile.rounding;
  return nearest;
}

/// The nearest of all bodies of a tool to all rigid bodies.
Approach nearestOf(const Model& model, int tool, const ToolPosture& posture, double time) {
  Approach nearest;
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool != tool) continue;
    const ToolProfile profile = toolProfile(body.shape);
    const double kept = kept_share * std::min(model.scene.discretization.spacing, profile.radius);
    for (const RigidBody& rigid : model.rigid.body) {
      if (rigid.encloses) continue;
      Approach at = nearestOf({rigid.shape, rigid.at(time)}, profile, bodyPose(body, posture));
      at.gap -= kept;
      if (at.gap < nearest.gap) nearest = at;
    }
  }
  return nearest;
}

}  // namespace

ToolPosture stoppedByRigidBodies(const Model& model, int tool, const ToolPosture& wanted, double time,
                                 double farthest) {
  ToolPosture posture = wanted;
  for (int k = 0; k < most_walls && farthest > 0; ++k) {
    const Approach nearest = nearestOf(model, tool, posture, time);
    if (!(nearest.gap < 0)) break;
    const double back = std::min(-nearest.gap, farthest);
    posture.pose.position += back * nearest.out;
    farthest -= back;
  }
  return posture;
}

ToolsAt stoppedByRigidBodies(const Model& model, const ToolsAt& wanted, double time) {
  ToolsAt tools = wanted;
  for (int t = 0; t < tools.count && !model.rigid.empty(); ++t) {
    ToolPosture& posture = tools.posture[static_cast<std::size_t>(t)];
    posture = stoppedByRigidBodies(model, t, posture, time, std::numeric_limits<double>::infinity());
  }
  return tools;
}

}  // namespace palpate

#include "step/rigid_stop.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/input_error.h"
#include "contact/tool_profile.h"
#include "step/tool_bodies.h"

namespace palpate {
namespace {

/// Of the spacing, and of the tool's radius, that a tool keeps from a rigid body.
constexpr double kept_share = HeldTissue::clearance;

constexpr int most_walls = 4;  // that it is pushed out of, or slides along, at once; in a narrower place it stands
constexpr double slope = 0.3;  // cosine of a wall that is before the tip, not beside it

struct Approach {
  double gap = std::numeric_limits<double>::infinity();  // m
  Vec3 out = Vec3::Zero();                               // unit, out of the rigid body
  const RigidBody* body = nullptr;
};

/// A rigid body where it is.
struct Obstacle {
  const RigidShape& shape;
  Pose pose;

  Approach at(const Vec3& x) const {
    Vec3 normal;
    const double gap = shape.gapAt(pose.toLocal(x), normal);
    return {gap, pose.orientation * normal.normalized(), nullptr};
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

/// m, half of a tool's extent about its middle, and what it keeps off.
double around(const ToolProfile& profile, double kept) {
  return std::hypot(0.5 * profile.length, profile.radius) + kept;
}

/// Calls call(approach) for what of a tool's bodies and the rigid bodies is near: gaps below 0 are all among them.
/// @param kept  share of the spacing, and of the tool's radius, that gaps count from
template <class Call>
void forEachNear(const Model& model, int tool, const ToolPosture& posture, double time, double kept, Call call) {
  for (const ToolBody& body : model.tools.body) {
    if (body.tool != tool) continue;
    const ToolProfile profile = toolProfile(body.shape);
    const Pose pose = bodyPose(body, posture);
    const Vec3 middle = pose.toWorld(Vec3(0, 0, 0.5 * profile.length));
    const double off = kept * std::min(model.scene.discretization.spacing, profile.radius);
    for (const RigidBody& rigid : model.rigid.body) {
      if (rigid.encloses) continue;
      const Obstacle obstacle{rigid.shape, rigid.at(time)};
      if (rigid.shape.leastGap(obstacle.pose.toLocal(middle)) > around(profile, off)) continue;
      Approach at = nearestOf(obstacle, profile, pose);
      at.gap -= off;
      at.body = &rigid;
      call(at);
    }
  }
}

/// The nearest of them.
Approach nearestOf(const Model& model, int tool, const ToolPosture& posture, double time, double kept) {
  Approach nearest;
  forEachNear(model, tool, posture, time, kept, [&](const Approach& at) {
    if (at.gap < nearest.gap) nearest = at;
  });
  return nearest;
}

ToolPosture pushedOut(const Model& model, int tool, const ToolPosture& wanted, double time, double farthest) {
  ToolPosture posture = wanted;
  for (int k = 0; k < most_walls && farthest > 0; ++k) {
    const Approach nearest = nearestOf(model, tool, posture, time, kept_share);
    if (!(nearest.gap < 0)) break;
    const double back = std::min(-nearest.gap, farthest);
    posture.pose.position += back * nearest.out;
    farthest -= back;
  }
  return posture;
}

/// A pose in a rigid body's frame.
Pose within(const Pose& body, const Pose& pose) {
  const Quat back = body.orientation.conjugate();
  return {body.toLocal(pose.position), back * pose.orientation};
}

/// The way of a tool in a tick among rigid bodies.
struct Passage {
  int pieces = 1;        // that see all that they would pass, at up to some 20 m/s
  double of_bodies = 0;  // m, that those near it go at most
};

Passage passageOf(const Model& model, int tool, const ToolPosture& from, const ToolPosture& to, double begin,
                  double end) {
  constexpr int most_pieces = 64;
  Passage passage;
  for (const ToolBody& body : model.tools.body) {
    if (body.tool != tool) continue;
    const ToolProfile profile = toolProfile(body.shape);
    const Pose first = bodyPose(body, from), last = bodyPose(body, to);
    const Vec3 middle = first.toWorld(Vec3(0, 0, 0.5 * profile.length));
    const double kept = kept_share * std::min(model.scene.discretization.spacing, profile.radius);
    for (const RigidBody& rigid : model.rigid.body) {
      if (rigid.encloses) continue;
      const Pose was = rigid.at(begin), is = rigid.at(end);
      const Pose start = within(was, first);
      const double way = largestTravel(body.shape, start, within(is, last));
      if (rigid.shape.leastGap(was.toLocal(middle)) > around(profile, kept) + way) continue;
      // A piece brings the core's surface, without its rounding, no deeper than to the body's.
      const double pieces = std::ceil(way / (kept + profile.rounding));
      passage.pieces = std::max(passage.pieces, static_cast<int>(std::min<double>(most_pieces, pieces)));
      passage.of_bodies = std::max(passage.of_bodies, largestTravel(body.shape, start, within(is, first)));
    }
  }
  return passage;
}

/// Where a tool would be too near to what holds the organ.
struct TooNear {
  double depth = 0;          // m; 0: nowhere
  Vec3 into = Vec3::Zero();  // unit, the way on which it would be
};

TooNear worstOfHeld(const Model& model, int tool, const ToolPosture& from, const Vec3& move,
                    const BoundaryShifts& shifts) {
  TooNear worst;
  double deepest = 0, shifted = 0;  // m
  for (const Vec3& shift : shifts.of) shifted = std::max(shifted, shift.norm());
  for (const ToolBody& body : model.tools.body) {
    if (body.tool != tool) continue;
    const ToolProfile profile = toolProfile(body.shape);
    const Pose pose = bodyPose(body, from);
    const Vec3 axis = pose.orientation * Vec3::UnitZ();
    const Vec3 middle = pose.position + 0.5 * profile.length * axis;
    const Vec3 front = pose.position + profile.radius * axis;  // the side of the skin that it is on
    const Quat to_tool = pose.orientation.conjugate();
    const double reach = std::hypot(0.5 * profile.length, profile.radius) + move.norm();
    if (model.held.box.exteriorDistance(middle) > reach + shifted) continue;
    for (const HeldTissue::Point& held : model.held.points) {
      const Vec3 at_rest = held.at(shifts);
      const double near = reach + held.clearance;
      if ((at_rest - middle).squaredNorm() > near * near || (front - at_rest).dot(held.outward) > 0) continue;
      const Vec3 before = to_tool * (at_rest - pose.position);
      const ToolDistance at = toolDistance(profile, before - to_tool * move);
      const double depth = held.clearance - at.distance;
      if (depth <= deepest || toolDistance(profile, before).distance < 0) continue;
      const Vec3 towards = pose.orientation * at.normal;
      const Vec3 into = held.outward.isZero(0) ? towards : held.outward;
      constexpr double rounding = 1e-12;  // m
      if (towards.dot(move) <= rounding || into.dot(move) <= rounding) continue;
      deepest = depth;
      worst = {depth / std::max(into.dot(towards), slope), into};
    }
  }
  return worst;
}

/// What a tool can do of `move`, m: all, to the bit, or without what would bring it nearer to what holds the organ than
/// the clearance. Away from there it is free, also where it begins nearer.
Vec3 heldBack(const Model& model, int tool, const ToolPosture& from, const Vec3& move, const BoundaryShifts& shifts) {
  const Vec3 ahead = -(from.pose.orientation * Vec3::UnitZ());
  Vec3 left = move;
  for (int k = 0; k < most_walls; ++k) {
    const TooNear worst = worstOfHeld(model, tool, from, left, shifts);
    if (worst.depth <= 0) return left;
    const double cosine = ahead.dot(worst.into), advance = left.dot(ahead);
    if (cosine > slope && advance > 0)  // not off a slope, which would take it from under the hand
      left -= std::min(worst.depth / cosine, advance) * ahead;
    else
      left -= std::min(worst.depth, left.dot(worst.into)) * worst.into;
  }
  return worstOfHeld(model, tool, from, left, shifts).depth > 0 ? Vec3::Zero() : left;
}

}  // namespace

ToolPosture RigidStop::beforeHeld(const Model& model, int tool, const ToolPosture& from,
                                  const ToolPosture& wanted) const {
  ToolPosture posture = wanted;
  if (!model.held.empty() && wanted.pose.position != from.pose.position) {
    const Vec3 move = wanted.pose.position - from.pose.position, free = heldBack(model, tool, from, move, shifts);
    if (free != move) posture.pose.position = from.pose.position + free;
  }
  return posture;
}

ToolPosture RigidStop::amongRigid(const Model& model, int tool, const ToolPosture& from,
                                  const ToolPosture& wanted) const {
  if (model.rigid.empty()) return wanted;
  const Passage passage = passageOf(model, tool, from, wanted, time - duration, time);
  const double pieces = passage.pieces;
  ToolPosture posture;
  Vec3 pushed = Vec3::Zero();
  for (int k = 1; k <= passage.pieces; ++k) {
    const ToolPosture free = between(from, wanted, k / pieces);
    posture = free;
    posture.pose.position += pushed;
    posture = pushedOut(model, tool, posture, time - duration * (1 - k / pieces),
                        (farthest + most_walls * passage.of_bodies) / pieces);
    pushed = posture.pose.position - free.pose.position;
  }
  return posture;
}

ToolPosture RigidStop::of(const Model& model, int tool, const ToolPosture& from, const ToolPosture& wanted) const {
  return amongRigid(model, tool, from, beforeHeld(model, tool, from, wanted));
}

bool RigidStop::failsAt(const Model& model, int tool, const ToolPosture& posture) const {
  return nearestOf(model, tool, posture, time, 0).gap < 0;
}

bool RigidStop::bears(const Model& model, int tool, const ToolPosture& posture, const Vec3& force) const {
  constexpr double as_near = 1.1;  // of what it keeps off
  constexpr double most = 0.5;     // of the force
  bool borne = false;
  forEachNear(model, tool, posture, time, as_near * kept_share,
              [&](const Approach& at) { borne |= at.gap < 0 && force.dot(at.out) < -most * force.norm(); });
  return borne;
}

ToolsAt stoppedByRigid(const Model& model, const ToolsAt& from, const ToolsAt& wanted, double time, double duration) {
  const RigidStop stop{time, duration};
  ToolsAt tools = wanted;
  for (int t = 0; t < tools.count; ++t) {
    const auto k = static_cast<std::size_t>(t);
    ToolPosture at = from.posture[k];
    const auto go = [&](double share) { at = stop.beforeHeld(model, t, at, between(at, wanted.posture[k], share)); };
    const auto wayLeft = [&] { return (wanted.posture[k].pose.position - at.pose.position).norm(); };
    // In pieces that see all that they would pass. Twice as many as the straight way has: it may slide.
    const double piece = model.held.empty()
                             ? std::numeric_limits<double>::infinity()
                             : std::max(model.held.least_clearance, 1e-3 * model.scene.discretization.spacing);
    for (double left = std::ceil(wayLeft() / piece) * 2; left >= 1 && wayLeft() > piece; --left) go(piece / wayLeft());
    if (wayLeft() <= piece) go(1);
    tools.posture[k].pose.position = at.pose.position;  // with all of its turn
    tools.posture[k] = stop.amongRigid(model, t, from.posture[k], tools.posture[k]);
  }
  return tools;
}

void checkToolStarts(const Model& model) {
  for (int t = 0; t < model.tools.toolCount(); ++t) {
    const Approach nearest = nearestOf(model, t, model.tools.tool[static_cast<std::size_t>(t)].start, 0, 0);
    if (nearest.gap < 0)
      throw InputError(model.scene.tools[static_cast<std::size_t>(t)].place,
                       "tool " + std::to_string(t + 1) + " starts inside the rigid body " + nearest.body->name,
                       "move its position out of it");
  }
}

}  // namespace palpate

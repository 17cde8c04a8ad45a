#include "realtime/loop/rigid_support.h"

#include <algorithm>
#include <cmath>

#include "approximation/neighbours.h"
#include "discretization/surface/surface_geometry.h"
#include "step/tool_bodies.h"

namespace palpate {
namespace {

constexpr double slope = 0.3;  // cosine of a wall that is before the tip, not beside it

/// By node: no component is free or moved.
std::vector<bool> heldNodes(const Model& model) {
  std::vector<bool> held(model.X.size(), false);
  for (const ImposedNode& imposed : model.essential.nodes) {
    if (imposed.node == ImposedNode::point) continue;
    const auto stands = [&](int b) { return b >= 0 && !model.essential.motions[static_cast<std::size_t>(b)].moves(); };
    held[static_cast<std::size_t>(imposed.node)] =
        std::all_of(imposed.boundary.begin(), imposed.boundary.end(), stands);
  }
  return held;
}

}  // namespace

RigidSupport::RigidSupport(const Model& model, int tool) {
  const std::vector<bool> held = heldNodes(model);
  if (std::find(held.begin(), held.end(), true) == held.end()) return;

  const Neighbours nodes(model.X, std::vector<double>(model.X.size(), model.scene.discretization.spacing));
  const auto clearanceAt = [&](int node) {  // the nearest node is itself
    const Vec3& X = model.X[static_cast<std::size_t>(node)];
    return clearance * (model.X[static_cast<std::size_t>(nodes.nearest(X, 2).back())] - X).norm();
  };
  const std::vector<Vec3> normal = vertexNormals(model.skin.surface);
  std::vector<bool> at_skin(model.X.size(), false);
  for (std::size_t v = 0; v < normal.size(); ++v) {
    const Vec3& x = model.skin.surface.vertices[v];
    const int node = nodes.nearest(x, 1).front();
    at_skin[static_cast<std::size_t>(node)] = true;
    if (held[static_cast<std::size_t>(node)]) held_.push_back({x, normal[v], clearanceAt(node)});
  }
  for (int i = 0; i < model.nodeCount(); ++i) {
    const auto node = static_cast<std::size_t>(i);
    if (held[node] && !at_skin[node]) held_.push_back({model.X[node], Vec3::Zero(), clearanceAt(i)});
  }
  for (const Held& h : held_) {
    box_.extend(h.position + Vec3::Constant(h.clearance));
    box_.extend(h.position - Vec3::Constant(h.clearance));
  }
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool != tool) continue;
    const ToolProfile profile = toolType(body.shape.kind).profile(body.shape);
    bodies_.push_back({body, profile, std::hypot(0.5 * profile.length, profile.radius)});
  }
}

RigidSupport::Approach RigidSupport::worst(const ToolPosture& from, const Vec3& move) const {
  Approach worst;
  double deepest = 0;  // m
  for (const Body& b : bodies_) {
    const Pose pose = bodyPose(b.body, from);
    const Vec3 axis = pose.orientation * Vec3::UnitZ();
    const Vec3 middle = pose.position + 0.5 * b.profile.length * axis;
    const Vec3 front = pose.position + b.profile.radius * axis;  // the side of the skin that it is on
    const Quat to_tool = pose.orientation.conjugate();
    const double reach = b.size + move.norm();
    if (box_.squaredExteriorDistance(middle) > reach * reach) continue;
    for (const Held& h : held_) {
      const double near = reach + h.clearance;
      if ((h.position - middle).squaredNorm() > near * near || (front - h.position).dot(h.outward) > 0) continue;
      const Vec3 before = to_tool * (h.position - pose.position);
      const ToolDistance at = toolDistance(b.profile, before - to_tool * move);
      const double depth = h.clearance - at.distance;
      if (depth <= deepest || toolDistance(b.profile, before).distance < 0) continue;
      const Vec3 towards = pose.orientation * at.normal;
      const Vec3 into = h.outward.isZero(0) ? towards : h.outward;
      constexpr double rounding = 1e-12;  // m
      if (towards.dot(move) <= rounding || into.dot(move) <= rounding) continue;
      deepest = depth;
      worst = {depth / std::max(into.dot(towards), slope), into};
    }
  }
  return worst;
}

Vec3 RigidSupport::stop(const ToolPosture& from, const Vec3& move) const {
  constexpr int most_walls = 4;  // that it slides along at once; in a narrower place it stands
  if (held_.empty()) return move;
  const Vec3 ahead = -(from.pose.orientation * Vec3::UnitZ());
  Vec3 left = move;
  for (int k = 0; k < most_walls; ++k) {
    const Approach approach = worst(from, left);
    if (approach.depth <= 0) return left;
    const double cosine = ahead.dot(approach.into), advance = left.dot(ahead);
    if (cosine > slope && advance > 0)  // not off a slope, which would take it from under the hand
      left -= std::min(approach.depth / cosine, advance) * ahead;
    else
      left -= std::min(approach.depth, left.dot(approach.into)) * approach.into;
  }
  return worst(from, left).depth > 0 ? Vec3::Zero() : left;
}

}  // namespace palpate

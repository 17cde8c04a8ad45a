#include "contact/rigid_bodies.h"

#include <algorithm>
#include <array>

namespace palpate {
namespace {

/// m: how far edges of a body are behind a face of the skin, no further than `farthest`; 0: they are not. What is
/// narrower than the skin's points are apart goes between them. Of a face whose corners it touches a second edge has to
/// be as deep: one that the body stands beside is behind it as far as it is long.
/// @param corner  of the face, m, in the body's frame, counterclockwise from outside
double edgeDepth(const std::vector<std::array<Vec3, 2>>& edges, const std::array<Vec3, 3>& corner, bool touches,
                 double farthest) {
  const Eigen::Array3d low = corner[0].cwiseMin(corner[1]).cwiseMin(corner[2]).array() - farthest,
                       high = corner[0].cwiseMax(corner[1]).cwiseMax(corner[2]).array() + farthest;
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
  double deepest = 0, second = 0;
  for (const auto& [begin, end] : edges) {
    if ((low > begin.cwiseMax(end).array()).any() || (high < begin.cwiseMin(end).array()).any()) continue;
    const Vec3 way = end - begin;
    double first = 0, last = 1;  // of the edge, straight before or behind the face
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 inwards = normal.cross(corner[(k + 1) % 3] - corner[k]);
      const double at = inwards.dot(begin - corner[k]), slope = inwards.dot(way);
      if (slope == 0 && at < 0) last = -1;
      if (slope > 0) first = std::max(first, -at / slope);
      if (slope < 0) last = std::min(last, -at / slope);
    }
    if (first > last) continue;
    const auto depthAt = [&](double share) { return -normal.dot(begin + share * way - corner[0]); };
    const double depth = std::max(depthAt(first), depthAt(last));
    if (depth > farthest) continue;
    second = std::max(second, std::min(depth, deepest));
    deepest = std::max(deepest, depth);
  }
  return touches ? second : deepest;
}

}  // namespace

Pose RigidBody::at(double time) const {
  const double s = motion.curve.at(time, motion.duration);
  const Quat turn(Eigen::AngleAxisd(s * motion.angle, motion.axis));
  return {s * motion.translation + motion.axis_point - turn * motion.axis_point, turn};
}

bool RigidBodies::moves() const {
  return std::any_of(body.begin(), body.end(), [](const RigidBody& b) { return b.motion.moves(); });
}

void addDeepest(const RigidBodies& bodies, const SkinModel& skin, const Float4* u, double time, double farthest,
                int first, int stride, RigidLoads& loads) {
  const int faces = static_cast<int>(skin.surface.triangles.size());
  for (std::size_t b = 0; b < bodies.body.size(); ++b) {
    const RigidBody& body = bodies.body[b];
    if (body.encloses) continue;
    const Pose pose = body.motion.moves() ? body.at(time) : Pose{};
    double deepest = 0;
    for (int v = first; v < skin.vertexCount(); v += stride) {
      Vec3 normal;
      deepest = std::max(deepest, -body.shape.gapAt(pose.toLocal(skinPosition(skin, v, u)), normal));
    }
    for (int t = first; t < faces && !body.edge.empty(); t += stride) {
      std::array<Vec3, 3> corner;
      bool touches = false;
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = pose.toLocal(skinPosition(skin, skin.surface.triangles[static_cast<std::size_t>(t)][k], u));
        Vec3 normal;
        touches = touches || body.shape.gapAt(corner[k], normal) <= static_cast<double>(near_gap);
      }
      deepest = std::max(deepest, edgeDepth(body.edge, corner, touches, farthest));
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

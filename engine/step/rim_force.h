#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "contact/contact_state.h"
#include "contact/skin.h"
#include "contact/tool_profile.h"
#include "model/model.h"

namespace palpate {

/// Cosine of what is turned away from another direction.
inline constexpr double turned_away = 0.7;

/// Whether a point is beside a rim of a tool that is sharper than the skin's edges are long there, and no further from
/// it than they are. @param local  m, in the tool's frame  @param area  m^2 of the skin that the point stands for
bool isBesideRim(const ToolProfile& tool, const Vec3& local, double area);

/// What pushes one body of a tool aside beside its rims that are sharper than the skin's edges are long, N: the sum of
/// the normal forces at points there that look more than 45 degrees away from what the body feels as a whole, across
/// that. Skin lies below such a rim and passes it; of points some stand beside the tool's wall, and are dragged along:
/// a flat end of 10 mm with a rim of 0.3 mm, drawn 3.5 mm over nodes 3 mm apart without friction, was held by 28 % of
/// its force, of which this has 25.
/// @param forEachPoint  calls `call(normal, press, place)` for each point that touches: unit, outwards, in the tool's
///                      frame; N along it; a function that gives the point's place, m, and its area, m^2
/// Real-time: no allocation, no lock, no throw.
template <class ForEachPoint>
Vec3 asideOfRims(const ToolProfile& tool, const Pose& body, ForEachPoint forEachPoint) {
  if (tool.corner_count < 3) return Vec3::Zero();
  Vec3 whole = Vec3::Zero(), beside = Vec3::Zero();  // tool's frame
  forEachPoint([&](const Vec3& normal, double press, const auto&) { whole += press * normal; });
  const Vec3 way = whole.normalized();
  forEachPoint([&](const Vec3& normal, double press, const auto& place) {
    if (!(press > 0 && normal.dot(way) < turned_away)) return;
    const auto [x, area] = place();
    if (isBesideRim(tool, body.toLocal(x), area)) beside += press * normal;
  });
  return body.orientation * (beside - beside.dot(way) * way);
}

/// N, the size of the sum over a tool's bodies.
/// @param contact  (body_count) after a step  @param tools  where they are  @param u  (node_count) m
/// Real-time as asideOfRims. Test: simulation/tool_contact_test.cpp
template <class Real>
double rimForce(const Model& model, std::span<const ContactState> contact, std::span<const ToolPosture> tools,
                const Real4<Real>* u, int tool) {
  const SkinModel& skin = model.skin;
  const auto vertexAt = [&](int v) {
    Vec3 x = skin.surface.vertices[static_cast<std::size_t>(v)];
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
      x += static_cast<double>(skin.N[e]) * toVec3(u[skin.node[e]]);
    return x;
  };
  Vec3 sum = Vec3::Zero();
  for (std::size_t b = 0; b < contact.size(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool != tool) continue;
    const Pose pose = bodyPose(body, tools[static_cast<std::size_t>(tool)]);
    const Mat3 world_from_tool = pose.orientation.toRotationMatrix();
    const auto pressOf = [&](const Vec3& normal, const Float4& force) {
      return std::max(0.0, (world_from_tool * normal).dot(toVec3(force)));
    };
    sum += asideOfRims(toolProfile(body.shape), pose, [&](auto call) {
      const ContactState& touch = contact[b];
      for (std::size_t c = 0; c < static_cast<std::size_t>(touch.count); ++c) {
        const Vec3 normal = touch.normal[c].template cast<double>();
        const int v = touch.vertex[c];
        call(normal, pressOf(normal, touch.force[c]),
             [&] { return std::pair<Vec3, double>(vertexAt(v), skin.area[static_cast<std::size_t>(v)]); });
      }
      const FaceSamples& samples = touch.samples;
      for (std::size_t s = 0; s < static_cast<std::size_t>(samples.count); ++s) {
        const Vec3 normal = samples.normal[s].template cast<double>();
        call(normal, pressOf(normal, samples.force[s]), [&] {
          const SkinPoint& point = samples.point[s];
          Vec3 x = Vec3::Zero();
          for (std::size_t k = 0; k < static_cast<std::size_t>(point.corners); ++k)
            x += static_cast<double>(point.share[k]) * vertexAt(point.vertex[k]);
          return std::pair<Vec3, double>(x, samples.area[s]);
        });
      }
    });
  }
  return sum.norm();
}

/// Of each tool that touches, as a share of its force; the largest. To be added to an expected error as what is
/// independent of it: hypot.
template <class Real>
double rimShare(const Model& model, std::span<const ContactState> contact, std::span<const ToolPosture> tools,
                const Real4<Real>* u, const ToolLoads& loads) {
  double largest = 0;
  for (int t = 0; t < model.tools.toolCount(); ++t)
    if (const double force = loads[static_cast<std::size_t>(t)].force.norm(); force > 0)
      largest = std::max(largest, rimForce<Real>(model, contact, tools, u, t) / force);
  return largest;
}

}  // namespace palpate

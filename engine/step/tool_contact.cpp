#include "step/tool_contact.h"

#include <algorithm>
#include <cmath>

#include "contact/samples/face_samples.h"
#include "contact/skin.h"
#include "step/tool_bodies.h"

namespace palpate {

namespace {

/// Adds what a body at this orientation feels; `sum`: of the normal forces.
void addContact(const Model& model, const State& state, const ContactState& contact, const Pose& body, const Vec3& tip,
                Vec3& torque, Vec3& sum) {
  forEachContactForce(contact, [&](int vertex, const Float4& force) {
    torque -= (skinPosition(model.skin, vertex, state.u.data()) - tip).cross(toVec3(force));
  });

  const Mat3 world_from_tool = body.orientation.toRotationMatrix();
  const auto press = [&](const Vec3f& side, const Float4& force) {
    const Vec3 normal = world_from_tool * side.cast<double>();
    sum += std::max(normal.dot(toVec3(force)), 0.0) * normal;
  };
  for (std::size_t c = 0; c < static_cast<std::size_t>(contact.count); ++c) press(contact.normal[c], contact.force[c]);
  const FaceSamples& samples = contact.samples;
  for (std::size_t s = 0; s < static_cast<std::size_t>(samples.count); ++s) press(samples.normal[s], samples.force[s]);
}

/// Cosine of what is turned away from another direction.
constexpr double turned = 0.7;

/// Whether a point is beside a rim that is sharper than `edge`, and no further from it than that, m.
bool isBesideRim(const ToolProfile& tool, const Vec3& local, double edge) {
  if (tool.rounding >= edge) return false;
  const double r = std::hypot(local.x(), local.y());
  for (std::size_t k = 1; k + 1 < static_cast<std::size_t>(tool.corner_count); ++k) {
    const MeridianPoint &before = tool.side_normal[k - 1], &after = tool.side_normal[k], &rim = tool.corner[k];
    if (rim.r > 0 && before.r * after.r + before.z * after.z < turned &&
        std::hypot(r - rim.r, local.z() - rim.z) < edge + tool.rounding)
      return true;
  }
  return false;
}

/// What pushes a body aside beside its rims.
Vec3 besideRims(const Model& model, const State& state, const ContactState& contact, const ToolProfile& tool,
                const Pose& body) {
  if (tool.corner_count < 3) return Vec3::Zero();
  const Mat3 world_from_tool = body.orientation.toRotationMatrix();
  const FaceSamples& samples = contact.samples;
  const auto forEach = [&](auto call) {  // (normal in the tool's frame, force, place, area)
    for (std::size_t c = 0; c < static_cast<std::size_t>(contact.count); ++c)
      call(
          contact.normal[c], contact.force[c],
          [&] { return skinPosition(model.skin, contact.vertex[c], state.u.data()); },
          model.skin.area[static_cast<std::size_t>(contact.vertex[c])]);
    for (std::size_t s = 0; s < static_cast<std::size_t>(samples.count); ++s)
      call(
          samples.normal[s], samples.force[s],
          [&] { return skinPosition(model.skin, samples.point[s], state.u.data()); },
          static_cast<double>(samples.area[s]));
  };
  const auto pressOf = [&](const Vec3& normal, const Float4& force) {
    return std::max(0.0, (world_from_tool * normal).dot(toVec3(force)));
  };
  Vec3 whole = Vec3::Zero(), beside = Vec3::Zero();  // tool's frame
  forEach([&](const Vec3f& side, const Float4& force, auto, double) {
    whole += pressOf(side.cast<double>(), force) * side.cast<double>();
  });
  const Vec3 way = whole.normalized();
  forEach([&](const Vec3f& side, const Float4& force, auto place, double area) {
    constexpr double edge_per_root = 1.07;  // of a vertex's area, on a net of even triangles
    const Vec3 normal = side.cast<double>();
    const double press = pressOf(normal, force);
    if (press > 0 && normal.dot(way) < turned &&
        isBesideRim(tool, body.toLocal(place()), edge_per_root * std::sqrt(area)))
      beside += press * normal;
  });
  return world_from_tool * (beside - beside.dot(way) * way);
}

}  // namespace

double rimForce(const Model& model, const State& state, int tool) {
  Vec3 sum = Vec3::Zero();
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool == tool)
      sum += besideRims(model, state, state.contact[b], toolProfile(body.shape), bodyPose(body, state.tool[tool]));
  }
  return sum.norm();
}

ToolContact toolContact(const Model& model, const State& state, int tool) {
  ToolContact result;
  Vec3 sum = Vec3::Zero();
  const ToolPosture& posture = state.tool[tool];
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool == tool)
      addContact(model, state, state.contact[b], bodyPose(body, posture), posture.pose.position, result.torque, sum);
  }
  const double size = sum.norm();
  if (size > 0) result.normal = -sum / size;
  return result;
}

ToolPostures posturesAtRest(const Model& model, const State& state) {
  ToolPostures postures = posturesOf(state);
  std::array<Vec3, max_tools> middle;
  std::array<double, max_tools> force{};
  middle.fill(Vec3::Zero());
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const auto tool = static_cast<std::size_t>(model.tools.body[b].tool);
    forEachContactForce(state.contact[b], [&](int vertex, const Float4& f) {
      const double size = toVec3(f).norm();
      middle[tool] += size * model.skin.surface.vertices[vertex];
      force[tool] += size;
    });
  }
  for (std::size_t t = 0; t < force.size(); ++t)
    if (force[t] > 0) postures[t].pose.position = middle[t] / force[t];
  return postures;
}

}  // namespace palpate

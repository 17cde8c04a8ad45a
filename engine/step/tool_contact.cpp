#include "step/tool_contact.h"

#include <algorithm>
#include <cmath>

#include "contact/samples/face_samples.h"
#include "contact/skin.h"
#include "step/rim_force.h"
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

}  // namespace

double rimForce(const Model& model, const State& state, int tool) {
  return rimForce<float>(model, state.contact, {state.tool.begin(), state.tool.end()}, state.u.data(), tool);
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

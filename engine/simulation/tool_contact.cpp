#include "simulation/tool_contact.h"

#include <algorithm>

#include "contact/skin.h"

namespace palpate {

ToolContact toolContact(const Model& model, const State& state) {
  const ContactState& contact = state.contact;
  const Vec3& tip = state.tool_pose.position;
  ToolContact result;
  forEachContactForce(contact, [&](int vertex, const Float4& force) {
    result.torque -= (skinPosition(model.skin, vertex, state.u.data()) - tip).cross(toVec3(force));
  });

  const Mat3 world_from_tool = state.tool_pose.orientation.toRotationMatrix();
  Vec3 sum = Vec3::Zero();
  const auto press = [&](const Vec3f& side, const Float4& force) {
    const Vec3 normal = world_from_tool * side.cast<double>();
    sum += std::max(normal.dot(toVec3(force)), 0.0) * normal;
  };
  for (std::size_t c = 0; c < static_cast<std::size_t>(contact.count); ++c) press(contact.normal[c], contact.force[c]);
  const FaceSamples& samples = contact.samples;
  for (std::size_t s = 0; s < static_cast<std::size_t>(samples.count); ++s) press(samples.normal[s], samples.force[s]);
  const double size = sum.norm();
  if (size > 0) result.normal = -sum / size;
  return result;
}

}  // namespace palpate

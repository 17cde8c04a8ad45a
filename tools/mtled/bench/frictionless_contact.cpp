#include "mtled/bench/frictionless_contact.h"

#include <algorithm>
#include <cmath>

namespace palpate::tools {
namespace {

using Eigen::Vector4f;

// As in contact/contact_solver.cpp.
constexpr int kMaxSweeps = 8;
constexpr float kTolerance = 1e-4F;
constexpr double kActiveGap = 0.01, kPressureCapDepth = 0.2, kDeep = 0.5, kSameSide = 0.5;

/// du_i += alpha / m_i N_i(X_v) f
void applyForce(const SkinModel& skin, int v, const Vector4f& f, float alpha, const float* inverse_mass, Float4* du) {
  const Group scaled = alpha * loadGroup(f.data());
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
    Float4& increment = du[skin.node[e]];
    store(increment, load(increment) + (skin.N[e] * inverse_mass[skin.node[e]]) * scaled);
  }
}

ToolDistance distanceBySide(const ToolProfile& tool, const Vec3& local, const Vec3& old_local, const Vec3f& memory) {
  ToolDistance d = toolDistance(tool, local);
  if (d.distance > -kDeep * tool.rounding) return d;
  const Vec3 side = memory.isZero() ? toolDistance(tool, old_local).normal : Vec3(memory.cast<double>());
  if (d.normal.dot(side) < kSameSide) d = {-exitDistance(tool, local, side), side};
  return d;
}

}  // namespace

Vec3 frictionlessContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose, const Pose& previous_pose,
                         double alpha, const float* inverse_mass, const Float4* u, Float4* du, ContactState& contact) {
  const ToolProfile profile = toolProfile(tool);
  const Mat3 world_from_tool = pose.orientation.toRotationMatrix(),
             tool_from_old_world = previous_pose.orientation.conjugate().toRotationMatrix();
  const auto alpha_f = static_cast<float>(alpha);
  // The last step's forces, turned with the tool, act from the start.
  const Mat3 turn = world_from_tool * tool_from_old_world;
  const auto turned = [&](const Float4& force) {
    Vector4f f = Vector4f::Zero();
    f.head<3>() = (turn * toVec3(force)).cast<float>();
    return f;
  };
  for (int slot = 0; slot < contact.count; ++slot)
    applyForce(skin, contact.vertex[slot], turned(contact.force[slot]), alpha_f, inverse_mass, du);
  int row_count = 0;
  for (int slot = 0; slot < contact.count; ++slot) {
    const int v = contact.vertex[slot];
    const Vector4f predicted = interpolateAtVertex(skin, v, du);
    const Vec3 start = skinPosition(skin, v, u), end = start + predicted.head<3>().cast<double>();
    const Vec3 local = world_from_tool.transpose() * (end - pose.position);
    const ToolDistance d =
        distanceBySide(profile, local, tool_from_old_world * (start - previous_pose.position), contact.normal[slot]);
    const Vector4f applied = turned(contact.force[slot]);
    if (!(d.distance <= kActiveGap * tool.radius)) {
      applyForce(skin, v, -applied, alpha_f, inverse_mass, du);
      contact.force[slot] = Float4{};
      contact.normal[slot].setZero();
      continue;
    }
    ContactRow& row = contact.row[row_count++];
    row.slot = slot;
    row.vertex = v;
    row.normal.head<3>() = (world_from_tool * d.normal).cast<float>();
    row.normal[3] = 0;
    row.gap = static_cast<float>(d.distance);
    row.predicted = predicted;
    row.stiffness = static_cast<float>(skin.bulk_stiffness * skin.area[v]);
    float compliance = 0;
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
      compliance += skin.N[e] * skin.N[e] * inverse_mass[skin.node[e]];
    row.mobility = alpha_f * compliance;
    row.penetration = 0;
    // The normal force goes with the tool, and so does the side.
    row.force[0] = std::sqrt(toVec3(contact.force[slot]).squaredNorm());
    contact.normal[slot] = d.normal.cast<float>();
    applyForce(skin, v, row.force[0] * row.normal - applied, alpha_f, inverse_mass, du);
  }

  const auto cap = static_cast<float>(kPressureCapDepth * tool.radius);
  int sweep = 0;
  for (bool settled = row_count == 0; sweep < kMaxSweeps && !settled; ++sweep) {
    float changed = 0, size = 0;
    for (int k = 0; k < row_count; ++k) {
      ContactRow& row = contact.row[sweep % 2 == 0 ? k : row_count - 1 - k];
      const float K = row.stiffness, A = row.mobility, before = row.force[0];
      const float penetration = -(row.gap + row.normal.dot(interpolateAtVertex(skin, row.vertex, du) - row.predicted));
      const float force = std::clamp(K / (1 + K * A) * (penetration + A * before), 0.0F, cap * K),
                  change = force - before;
      row.penetration = penetration - A * change;
      row.force[0] = force;
      size += force * force;
      if (change == 0) continue;
      changed += change * change;
      applyForce(skin, row.vertex, change * row.normal, alpha_f, inverse_mass, du);
    }
    settled = changed <= kTolerance * kTolerance * size;
  }

  Vec3 on_tissue = Vec3::Zero();
  contact.max_penetration = 0;
  contact.contact_count = 0;
  contact.sweep_count = sweep;
  for (int r = 0; r < row_count; ++r) {
    const ContactRow& row = contact.row[r];
    const Vector4f force = row.force[0] * row.normal;
    store(contact.force[row.slot], loadGroup(force.data()));
    on_tissue += force.head<3>().cast<double>();
    contact.max_penetration = std::max(contact.max_penetration, static_cast<double>(row.penetration));
    contact.contact_count += row.force[0] != 0;
  }
  return -on_tissue;
}

}  // namespace palpate::tools

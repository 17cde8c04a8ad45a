#include "contact/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

using Eigen::Vector4f;

/// Sweeps at most. Warm-started contacts on tissue need one to five.
constexpr int kMaxSweeps = 8;

/// Done when a sweep changes the forces by less than this part of their size (2-norms over vertices).
constexpr float kTolerance = 1e-4F;

/// Gap, per tool radius, within which a vertex takes part though it does not touch: the forces on its
/// neighbours may push it against the tool within the step. If missed, the next step has it.
constexpr double kActiveGap = 0.01;

/// Depth, per tool radius, from which the pressure grows no further (100 Young's moduli). Only a
/// tool that is put into the tissue gets there; the cap lets it be expelled instead of exploding.
constexpr double kPressureCapDepth = 0.2;

/// Part of the rounding, in depth, from which on a turn of the normal by more than 60 degrees is distrusted.
constexpr double kDeep = 0.5;
constexpr double kSameSide = 0.5;

Vector4f lanes(const Vec3& a) {
  return {static_cast<float>(a.x()), static_cast<float>(a.y()), static_cast<float>(a.z()), 0.0F};
}

/// du_i += alpha / m_i N_i(X_v) f
void applyForce(const SkinModel& skin, int v, const Vector4f& f, float alpha, const float* inverse_mass, Float4* du) {
  const Group scaled = alpha * loadGroup(f.data());
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
    Float4& increment = du[skin.node[e]];
    store(increment, load(increment) + (skin.N[e] * inverse_mass[skin.node[e]]) * scaled);
  }
}

/// The vertex's response to a force on itself, per alpha: sum_i N_i^2 / m_i.
float compliance(const SkinModel& skin, int v, const float* inverse_mass) {
  float sum = 0.0F;
  for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e) {
    sum += skin.N[e] * skin.N[e] * inverse_mass[skin.node[e]];
  }
  return sum;
}

/// Rotations and places of one step, computed once.
struct Motion {
  explicit Motion(const Pose& from, const Pose& to)
      : world_from_tool(to.orientation.toRotationMatrix()),
        world_from_old_tool(from.orientation.toRotationMatrix()),
        turn(world_from_tool * world_from_old_tool.transpose()),
        position(to.position),
        old_position(from.position) {}

  Mat3 world_from_tool, world_from_old_tool, turn;
  Vec3 position, old_position;
};

/// Signed distance at the end of the step. Deep inside, where the nearest side may not be the one
/// that the vertex came in by, the distance is that to leave by the remembered side.
ToolDistance distanceBySide(const ToolProfile& tool, const Vec3& local, const Vec3& old_local, const Vec3f& memory) {
  ToolDistance d = toolDistance(tool, local);
  if (d.distance > -kDeep * tool.rounding) return d;
  const Vec3 side = memory.isZero() ? toolDistance(tool, old_local).normal : Vec3(memory.cast<double>());
  if (d.normal.dot(side) < kSameSide) d = {-exitDistance(tool, local, side), side};
  return d;
}

/// Solves one vertex's law with all other forces held; returns the change of its force.
Vector4f updateForce(ContactRow& row, const Vector4f& increment, float friction, float force_cap) {
  const float K = row.stiffness, A = row.mobility;
  const float softened = K / (1.0F + K * A);  // f = K (d_free - A f)
  const float normal_old = row.normal.dot(row.force);
  const float penetration = -(row.gap + row.normal.dot(increment - row.predicted));
  const float normal_new = std::clamp(softened * (penetration + A * normal_old), 0.0F, force_cap * K);
  Vector4f force = normal_new * row.normal;
  if (friction > 0.0F && normal_new > 0.0F) {
    Vector4f slip = increment - row.tool_increment;
    slip -= row.normal.dot(slip) * row.normal;
    const Vector4f tangential_old = row.force - normal_old * row.normal;
    Vector4f tangential = (row.stick - K * (slip - A * tangential_old)) / (1.0F + K * A);
    const float size = tangential.norm();
    const float limit = friction * normal_new;
    if (size > limit) tangential *= limit / size;
    force += tangential;
  }
  row.penetration = penetration - A * (normal_new - normal_old);
  const Vector4f change = force - row.force;
  row.force = force;
  return change;
}

}  // namespace

Vec3 solveContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose, const Pose& previous_pose,
                  double friction, double alpha, const float* inverse_mass, const Float4* u, Float4* du,
                  ContactState& contact) {
  const Motion motion(previous_pose, pose);
  const ToolProfile profile = toolProfile(tool);
  const float mu = static_cast<float>(friction), alpha_f = static_cast<float>(alpha);

  // Rows: the vertices that touch, or nearly.
  int row_count = 0;
  for (int slot = 0; slot < contact.count; ++slot) {
    const int v = contact.vertex[slot];
    const Vector4f predicted = interpolateAtVertex(skin, v, du);
    const Vec3 start = skinPosition(skin, v, u);
    const Vec3 end = start + predicted.head<3>().cast<double>();
    const Vec3 local = motion.world_from_tool.transpose() * (end - motion.position);
    const Vec3 old_local = motion.world_from_old_tool.transpose() * (start - motion.old_position);
    const ToolDistance d = distanceBySide(profile, local, old_local, contact.normal[slot]);
    if (!(d.distance <= kActiveGap * tool.radius)) {  // also where it is not a number
      contact.force[slot] = Float4{};
      contact.normal[slot].setZero();
      continue;
    }
    ContactRow& row = contact.row[row_count++];
    row.slot = slot;
    row.vertex = v;
    row.normal = lanes(Vec3(motion.world_from_tool * d.normal));
    row.gap = static_cast<float>(d.distance);
    row.predicted = predicted;
    row.tool_increment = lanes(Vec3(end - (motion.world_from_old_tool * local + motion.old_position)));
    row.stiffness = static_cast<float>(skin.bulk_stiffness * skin.area[v]);
    row.mobility = alpha_f * compliance(skin, v, inverse_mass);
    row.penetration = 0.0F;

    // Last step's force, turned with the tool and the normal.
    const Vec3 old_force = motion.turn * toVec3(contact.force[slot]);
    const Vec3 old_normal = motion.world_from_tool * contact.normal[slot].cast<double>();
    const double normal_force = old_normal.dot(old_force);
    row.stick = lanes(Vec3(old_force - normal_force * old_normal));
    row.stick -= row.normal.dot(row.stick) * row.normal;
    row.force = static_cast<float>(normal_force) * row.normal + row.stick;
    contact.normal[slot] = d.normal.cast<float>();
  }

  for (int r = 0; r < row_count; ++r) {
    applyForce(skin, contact.row[r].vertex, contact.row[r].force, alpha_f, inverse_mass, du);
  }
  const float cap = static_cast<float>(kPressureCapDepth * tool.radius);
  int sweep = 0;
  for (bool settled = row_count == 0; sweep < kMaxSweeps && !settled; ++sweep) {
    float changed = 0.0F, size = 0.0F;
    for (int k = 0; k < row_count; ++k) {
      ContactRow& row = contact.row[sweep % 2 == 0 ? k : row_count - 1 - k];
      const Vector4f change = updateForce(row, interpolateAtVertex(skin, row.vertex, du), mu, cap);
      size += row.force.squaredNorm();
      if (change.isZero(0.0F)) continue;
      changed += change.squaredNorm();
      applyForce(skin, row.vertex, change, alpha_f, inverse_mass, du);
    }
    settled = changed <= kTolerance * kTolerance * size;
  }

  Vec3 on_tissue = Vec3::Zero();
  contact.max_penetration = 0.0;
  contact.contact_count = 0;
  contact.sweep_count = sweep;
  for (int r = 0; r < row_count; ++r) {
    const ContactRow& row = contact.row[r];
    store(contact.force[row.slot], loadGroup(row.force.data()));
    on_tissue += row.force.head<3>().cast<double>();
    contact.max_penetration = std::max(contact.max_penetration, static_cast<double>(row.penetration));
    contact.contact_count += row.force.isZero(0.0F) ? 0 : 1;
  }
  return -on_tissue;
}

}  // namespace palpate

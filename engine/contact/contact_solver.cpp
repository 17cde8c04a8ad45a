#include "contact/contact_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "contact/coulomb_friction.h"
#include "contact/samples/face_samples.h"
#include "contact/skin_forces.h"
#include "contact/tool_set.h"
#include "contact/tool_side.h"

namespace palpate {
namespace {

using Eigen::Vector4f;

/// Sweeps at most. Warm-started contacts on tissue need one to five.
constexpr int kMaxSweeps = 8;

/// The same where a tool gives way.
constexpr int kMaxYieldingSweeps = 24;

/// Done when a sweep changes the forces by less than this part of their size (2-norms over vertices).
constexpr float kTolerance = 1e-4F;

/// Gap, per tool radius, within which a vertex takes part though it does not touch: the forces on its
/// neighbours may push it against the tool within the step. If missed, the next step has it.
constexpr double kActiveGap = 0.01;

/// Depth, per tool radius, from which the pressure grows no further (100 Young's moduli). Only a
/// tool that is put into the tissue gets there; the cap lets it be expelled instead of exploding.
constexpr double kPressureCapDepth = 0.2;

Vector4f lanes(const Vec3& a) {
  return {static_cast<float>(a.x()), static_cast<float>(a.y()), static_cast<float>(a.z()), 0.0F};
}

/// Bound on a sample's: its corners move each other no more than themselves. Too large a response makes the sweeps
/// careful, not wrong.
float compliance(const SkinModel& skin, const SkinPoint& sample, const float* inverse_mass) {
  float root = 0.0F;
  for (int c = 0; c < sample.corners; ++c)
    root += sample.share[c] * std::sqrt(compliance(skin, sample.vertex[c], inverse_mass));
  return root * root;
}

Vector4f interpolateAt(const SkinModel& skin, const ContactRow& row, const Float4* field) {
  return row.sample == nullptr ? interpolateAtVertex(skin, row.vertex, field) : interpolate(skin, *row.sample, field);
}

void applyForce(const SkinModel& skin, const SkinPoint& sample, const Vector4f& f, float alpha,
                const float* inverse_mass, Float4* du) {
  for (int c = 0; c < sample.corners; ++c)
    applyForce(skin, sample.vertex[c], sample.share[c] * f, alpha, inverse_mass, du);
}

void applyForce(const SkinModel& skin, const ContactRow& row, const Vector4f& f, float alpha, const float* inverse_mass,
                Float4* du) {
  if (row.sample == nullptr) return applyForce(skin, row.vertex, f, alpha, inverse_mass, du);
  applyForce(skin, *row.sample, f, alpha, inverse_mass, du);
}

/// Squared length of a remembered side (a unit vector otherwise) from which on it says that the tool came from inside.
constexpr float kPassing = 2.0F;

/// Whether a tool that comes to the skin at vertex v would push it along `way`, outwards: it comes from inside then,
/// and passes, or it would carry the skin off. Cosine beyond which that is so: a tool in a dent touches its walls
/// sideways.
bool comesFromInside(const SkinModel& skin, int v, const Vec3& way, const Float4* u) {
  constexpr double kOutwards = 0.5;
  if (skin.topology->face_begin.empty()) return false;
  Vec3 outside = Vec3::Zero();
  for (int k = skin.topology->face_begin[v]; k < skin.topology->face_begin[v + 1]; ++k) {
    const auto& corner = skin.surface.triangles[skin.topology->face_of[k]];
    const Vec3 x = skinPosition(skin, corner[0], u);
    outside += (skinPosition(skin, corner[1], u) - x).cross(skinPosition(skin, corner[2], u) - x);
  }
  return way.dot(outside) > kOutwards * outside.norm();
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
    force += frictionForce(row.stick, slip, tangential_old, K, A, friction * normal_new);
  }
  row.penetration = penetration - A * (normal_new - normal_old);
  const Vector4f change = force - row.force;
  row.force = force;
  return change;
}

/// One tool's part of the system.
struct Touching {
  const ToolShape* tool;
  ContactState* contact;
  Motion motion;
  ToolProfile profile;
  float mu, cap;  // cap: m, of the depth that counts
  int row_count = 0;
  ToolHold* hold;
  Vec3 apart;
  Vec3 given = Vec3::Zero();          // m, by how much it has given way in its pose
  Vector4f shift = Vector4f::Zero();  // m, from the pose, as far as it has moved since

  explicit Touching(const TouchingTool& t)
      : tool(t.shape),
        contact(t.contact),
        motion(t.previous_pose, t.pose),
        profile(toolProfile(*t.shape)),
        mu(static_cast<float>(t.friction)),
        cap(static_cast<float>(kPressureCapDepth * t.shape->radius)),
        hold(t.hold),
        apart(t.apart) {
    if (hold != nullptr) given = hold->way + hold->opening * apart;
  }

  std::span<ContactRow> rows() const { return {contact->row.data(), static_cast<std::size_t>(row_count)}; }
  void follow() { shift = lanes(hold->way + hold->opening * apart - given); }

  Vector4f turned(const Float4& force) const { return lanes(Vec3(motion.turn * toVec3(force))); }
};

/// The last step's forces, turned with the tool, act from the start: the gaps and normals are then those of where the
/// skin goes. Without them a long step takes it far into the tool, and what it finds there depends on dt.
void applyLastForces(const SkinModel& skin, const Touching& body, float alpha, const float* inverse_mass, Float4* du) {
  const ContactState& contact = *body.contact;
  for (int slot = 0; slot < contact.count; ++slot)
    applyForce(skin, contact.vertex[slot], body.turned(contact.force[slot]), alpha, inverse_mass, du);
  const FaceSamples& samples = contact.samples;
  for (int slot = 0; slot < samples.count; ++slot)
    applyForce(skin, samples.point[slot], body.turned(samples.force[slot]), alpha, inverse_mass, du);
}

/// Rows: the vertices that touch, or nearly, then the samples of stretched faces.
void makeRows(const SkinModel& skin, Touching& body, float alpha_f, const float* inverse_mass, const Float4* u,
              Float4* du) {
  const ToolShape& tool = *body.tool;
  const ToolProfile& profile = body.profile;
  const Motion& motion = body.motion;
  ContactState& contact = *body.contact;
  FaceSamples& samples = contact.samples;
  int row_count = 0;
  for (int k = 0; k < contact.count + samples.count; ++k) {
    const bool is_vertex = k < contact.count;
    const int slot = is_vertex ? k : k - contact.count;
    const SkinPoint* const sample = is_vertex ? nullptr : &samples.point[slot];
    const int v = is_vertex ? contact.vertex[slot] : sample->vertex[0];
    Float4& last_force = (is_vertex ? contact.force : samples.force)[slot];
    Vec3f& last_normal = (is_vertex ? contact.normal : samples.normal)[slot];
    Vec3f& side = (is_vertex ? contact.side : samples.side)[slot];

    const Vector4f predicted = is_vertex ? interpolateAtVertex(skin, v, du) : interpolate(skin, *sample, du);
    const Vec3 start = is_vertex ? skinPosition(skin, v, u) : skinPosition(skin, *sample, u);
    const Vec3 end = start + predicted.head<3>().cast<double>();
    const Vec3 local = motion.world_from_tool.transpose() * (end - motion.position);
    const Vec3 old_local = motion.world_from_old_tool.transpose() * (start - motion.old_position);
    if (side.squaredNorm() > kPassing) {  // the tool came to it from inside, and it is left alone until it has passed
      if (toolDistance(profile, local).distance <= kActiveGap * tool.radius) continue;
      side.setZero();
    }
    ToolDistance d = distanceBySide(profile, local, old_local, last_normal, side);
    if (!is_vertex) d.distance += static_cast<double>(samples.lift[slot]);
    const Vector4f applied = body.turned(last_force);
    const bool touches = d.distance <= kActiveGap * tool.radius;  // not where it is not a number
    const bool from_inside =
        touches && last_normal.isZero() && comesFromInside(skin, v, motion.world_from_tool * d.normal, u);
    if (!touches || from_inside) {
      if (is_vertex)
        applyForce(skin, v, -applied, alpha_f, inverse_mass, du);
      else
        applyForce(skin, *sample, -applied, alpha_f, inverse_mass, du);
      last_force = Float4{};
      last_normal.setZero();
      side = from_inside ? Vec3f(2, 0, 0) : Vec3f::Zero();
      continue;
    }
    ContactRow& row = contact.row[row_count++];
    row.slot = slot;
    row.vertex = v;
    row.sample = sample;
    row.gap = static_cast<float>(d.distance);
    row.predicted = predicted;
    row.tool_increment = lanes(Vec3(end - (motion.world_from_old_tool * local + motion.old_position)));
    row.stiffness =
        static_cast<float>(skin.bulk_stiffness * (is_vertex ? skin.area[v] : static_cast<double>(samples.area[slot])));
    row.mobility = alpha_f * (is_vertex ? compliance(skin, v, inverse_mass) : compliance(skin, *sample, inverse_mass));
    row.penetration = 0.0F;

    // Along the normal of where the point was at the step's start, so that what slides over the tool gains no energy.
    // Along the one of where it will be, a force that stays pushes it on, both ways: by N |du|^2 / R a step.
    const bool touched = !last_normal.isZero();
    row.normal = lanes(Vec3(motion.world_from_tool * (touched ? Vec3(last_normal.cast<double>()) : d.normal)));
    row.force = applied;
    row.stick = applied - row.normal.dot(applied) * row.normal;
    last_normal = d.normal.cast<float>();
  }
  body.row_count = row_count;
}

/// Goes once over all points of a tool. `changed`, `size`: squared sums of the forces' changes and of the forces.
void sweepOnce(const SkinModel& skin, Touching& body, bool forwards, float alpha, const float* inverse_mass, Float4* du,
               float& changed, float& size) {
  for (int k = 0; k < body.row_count; ++k) {
    ContactRow& row = body.contact->row[forwards ? k : body.row_count - 1 - k];
    const Vector4f change = updateForce(row, interpolateAt(skin, row, du) - body.shift, body.mu, body.cap);
    size += row.force.squaredNorm();
    if (change.isZero(0.0F)) continue;
    changed += change.squaredNorm();
    applyForce(skin, row, change, alpha, inverse_mass, du);
  }
}

/// A way that a tool can give: as a whole along the force on it, or by its opening.
struct Giving {
  std::span<std::optional<Touching>> bodies;  // of one tool
  bool opens;
  double limit;       // N
  Vec3 out{0, 0, 0};  // unit, as a whole
  double size = 0;    // N, what the hand bears

  Vec3 along(const Touching& body) const { return opens ? body.apart : out; }

  void measure() {
    Vec3 on_tool = Vec3::Zero();
    size = 0;
    for (const auto& body : bodies) {
      Vec3 force = Vec3::Zero();
      for (const ContactRow& row : body->rows()) force -= row.force.head<3>().cast<double>();
      on_tool += force;
      size += force.dot(body->apart);  // half of what presses a finger away from the other
    }
    if (opens) return;
    size = on_tool.norm();
    out = size > 0 ? Vec3(on_tool / size) : Vec3::Zero();
  }

  /// All forces that the tool feels times `share`.
  void scale(float share, const SkinModel& skin, float alpha, const float* inverse_mass, Float4* du) const {
    for (const auto& body : bodies)
      for (ContactRow& row : body->rows()) {
        applyForce(skin, row, (share - 1.0F) * row.force, alpha, inverse_mass, du);
        row.force *= share;
      }
  }

  /// m, that the tool must go for its layer to carry the forces as they are, on the mean.
  double distance(const SkinModel& skin, const Float4* du) const {
    double excess = 0, weight = 0;
    for (const auto& body : bodies) {
      const Vector4f way = lanes(along(*body));
      for (const ContactRow& row : body->rows()) {
        const float force = row.normal.dot(row.force);
        if (force <= 0) continue;
        const Vector4f moved = interpolateAt(skin, row, du) - body->shift - row.predicted;
        const float penetration = -(row.gap + row.normal.dot(moved));
        excess += static_cast<double>(force * (penetration - force / row.stiffness));
        weight -= static_cast<double>(force * row.normal.dot(way));
      }
    }
    return weight > 0 ? excess / weight : 0;
  }
};

/// Lets a tool give way where its hand bears more than it can, or come back where it bears less.
/// @return whether that is as it should be already
bool giveWay(Giving giving, const SkinModel& skin, float alpha, const float* inverse_mass, Float4* du) {
  constexpr double close = 0.02, most_growth = 1.5;  // of the limit; of the forces in one sweep
  ToolHold& hold = *giving.bodies.front()->hold;
  giving.measure();
  const bool gave = giving.opens ? hold.opening > 0 : !hold.way.isZero(0);
  if (giving.limit <= 0 || (giving.size <= giving.limit && !gave)) return true;
  double t = 0;
  if (giving.size > 0) {
    const double share = std::min(giving.limit / giving.size, most_growth);
    giving.scale(static_cast<float>(share), skin, alpha, inverse_mass, du);
    t = giving.distance(skin, du);
  }
  const double before = giving.opens ? hold.opening : hold.way.norm();
  if (giving.size <= 0 || (t < 0 && -t >= before)) {
    if (giving.opens)
      hold.opening = 0;
    else
      hold.way.setZero();
  } else if (giving.opens) {
    hold.opening = std::min(hold.opening + t, hold.longest);
  } else {
    hold.way += t * giving.out;
    if (const double length = hold.way.norm(); length > hold.longest) hold.way *= hold.longest / length;
  }
  for (auto& body : giving.bodies) body->follow();
  return std::abs(giving.size - giving.limit) <= close * giving.limit;
}

/// Keeps the forces for the next step. Returns that on the tool.
Vec3 finish(const Touching& body, int sweeps) {
  ContactState& contact = *body.contact;
  Vec3 on_tissue = Vec3::Zero();
  contact.max_penetration = 0.0;
  contact.contact_count = 0;
  contact.sweep_count = sweeps;
  for (int r = 0; r < body.row_count; ++r) {
    const ContactRow& row = contact.row[r];
    store((row.sample == nullptr ? contact.force : contact.samples.force)[row.slot], loadGroup(row.force.data()));
    on_tissue += row.force.head<3>().cast<double>();
    contact.max_penetration = std::max(contact.max_penetration, static_cast<double>(row.penetration));
    contact.contact_count += row.force.isZero(0.0F) ? 0 : 1;
  }
  return -on_tissue;
}

/// Solves for up to `capacity` tools.
template <std::size_t capacity>
void solve(const SkinModel& skin, std::span<TouchingTool> tools, double alpha, const float* inverse_mass,
           const Float4* u, Float4* du) {
  const auto alpha_f = static_cast<float>(alpha);
  std::array<std::optional<Touching>, capacity> bodies;
  const std::size_t count = tools.size();
  for (std::size_t b = 0; b < count; ++b) {
    bodies[b].emplace(tools[b]);
    applyLastForces(skin, *bodies[b], alpha_f, inverse_mass, du);
  }
  int row_count = 0;
  for (std::size_t b = 0; b < count; ++b) {
    makeRows(skin, *bodies[b], alpha_f, inverse_mass, u, du);
    row_count += bodies[b]->row_count;
  }
  // What may give way: tools as a whole, and jaws.
  const auto forEachGiving = [&](auto each) {
    for (std::size_t b = 0, end = 0; b < count; b = end) {
      ToolHold* hold = bodies[b]->hold;
      for (end = b + 1; end < std::min(count, capacity) && bodies[end]->hold == hold && hold != nullptr;) ++end;
      if (hold == nullptr) continue;
      const std::span<std::optional<Touching>> own(&bodies[b], end - b);
      each(Giving{own, false, hold->max_force});
      if (hold->max_pinch > 0) each(Giving{own, true, hold->max_pinch});
    }
  };
  int sweep = 0, most = kMaxSweeps;
  for (bool settled = row_count == 0; sweep < most && !settled; ++sweep) {
    float changed = 0.0F, size = 0.0F;
    const bool forwards = sweep % 2 == 0;
    for (std::size_t b = 0; b < count; ++b)
      sweepOnce(skin, *bodies[forwards ? b : count - 1 - b], forwards, alpha_f, inverse_mass, du, changed, size);
    settled = changed <= kTolerance * kTolerance * size;
    forEachGiving([&](const Giving& giving) {
      if (giveWay(giving, skin, alpha_f, inverse_mass, du)) return;
      settled = false;
      most = kMaxYieldingSweeps;
    });
  }
  forEachGiving([&](Giving giving) {  // what is left, and no hand bears
    giving.measure();
    if (giving.limit > 0 && giving.size > giving.limit)
      giving.scale(static_cast<float>(giving.limit / giving.size), skin, alpha_f, inverse_mass, du);
  });
  for (std::size_t b = 0; b < count; ++b) tools[b].force = finish(*bodies[b], sweep);
}

}  // namespace

Vec3 solveContact(const SkinModel& skin, const ToolShape& tool, const Pose& pose, const Pose& previous_pose,
                  double friction, double alpha, const float* inverse_mass, const Float4* u, Float4* du,
                  ContactState& contact) {
  TouchingTool one{&tool, pose, previous_pose, friction, &contact};
  solve<1>(skin, {&one, 1}, alpha, inverse_mass, u, du);
  return one.force;
}

void solveContacts(const SkinModel& skin, std::span<TouchingTool> tools, double alpha, const float* inverse_mass,
                   const Float4* u, Float4* du) {
  if (tools.size() == 1)
    solve<1>(skin, tools, alpha, inverse_mass, u, du);
  else
    solve<max_tool_bodies>(skin, tools, alpha, inverse_mass, u, du);
}

}  // namespace palpate

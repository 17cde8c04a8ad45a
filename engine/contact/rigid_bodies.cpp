#include "contact/rigid_bodies.h"

#include <algorithm>
#include <cmath>

#include "contact/coulomb_friction.h"
#include "contact/skin_forces.h"

namespace palpate {
namespace {

using Eigen::Vector4f;

/// What a kidney on a table needs at rest is 8 sweeps, 14 at most. Ended after 8 whatever they have come to, a node
/// trembles at 20 mm/s for ever, and friction lets go of it by and by.
constexpr int most_sweeps = 32;

/// Of the forces: the kidney's nodes tremble at 2e-6 m/s, and at a hundred times that with 1e-4, for a sweep less.
constexpr float settled_change = 1e-6F;

/// m, within which a point takes part though it does not touch: forces on its neighbours may push it there.
constexpr double near_gap = 1e-5;

/// m a step, by which a point that is outside comes back at most.
constexpr double fastest_return = 2e-5;

/// m, that nodes go until points near a body are looked for anew: in a tick at 1 m/s.
constexpr double look_ahead = 2e-3;

Vector4f lanesOf(const Float4& a) { return {a.x, a.y, a.z, 0}; }
Vector4f lanesOf(const Vec3& a) {
  return {static_cast<float>(a.x()), static_cast<float>(a.y()), static_cast<float>(a.z()), 0};
}
bool isZero(const Float4& a) { return a.x == 0 && a.y == 0 && a.z == 0; }

/// Where a body is at a time.
struct BodyPlace {
  BodyPlace(const RigidBody& body, double time) {
    if (!body.motion.moves()) return;
    const Pose pose = body.at(time);
    turn = pose.orientation.toRotationMatrix();
    shift = pose.position;
  }
  Vec3 toBody(const Vec3& x) const { return turn.transpose() * (x - shift); }
  Vec3 toWorld(const Vec3& X) const { return turn * X + shift; }

  Mat3 turn = Mat3::Identity();
  Vec3 shift = Vec3::Zero();  // m
};

/// What one step solves.
struct RigidStep {
  const RigidBodies& bodies;
  const SkinModel& skin;
  double begin, end;  // s
  float alpha;
  const float* inverse_mass;
  const Float4* u;
  Float4* du;

  Vector4f wayOf(int v) const { return interpolateAtVertex(skin, v, du); }
  void push(int v, const Vector4f& f) const {
    if (!f.isZero(0)) applyForce(skin, v, f, alpha, inverse_mass, du);
  }
};

/// Bound on how far a point of the skin has gone over a body since the points near it were looked for, at the end of
/// the step, m.
double farthestWay(const RigidStep& step, const RigidState& state) {
  float largest = 0;
  for (std::size_t i = 0; i < state.near_u.size(); ++i) {
    const Group way = load(step.u[i]) + load(step.du[i]) - load(state.near_u[i]);
    largest = std::max(largest, way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
  }
  const double of_points = step.bodies.row_sum * std::sqrt(static_cast<double>(largest));
  double of_bodies = 0;
  for (const RigidBody& body : step.bodies.body) {
    if (!body.motion.moves()) continue;
    const BodyPlace then(body, state.near_time), now(body, step.end);
    of_bodies = std::max(of_bodies, (then.toBody(state.near_centre) - now.toBody(state.near_centre)).norm() +
                                        (then.turn - now.turn).norm() * (state.near_radius + of_points));
  }
  return of_points + of_bodies;
}

/// The points that can touch a body while nothing goes further than `reach` (m) from where it is.
void findNear(const RigidStep& step, double reach, RigidState& state) {
  const bool moves = step.bodies.moves();
  Box3 box;
  state.near_count = 0;
  for (const RigidBody& body : step.bodies.body) {
    const BodyPlace place(body, step.begin);
    for (int p = body.begin; p < body.end; ++p) {
      const Vec3 x = skinPosition(step.skin, step.bodies.vertex[p], step.u);
      if (moves) box.extend(x);
      if (body.shape.leastGap(place.toBody(x)) > near_gap + reach && isZero(state.force[p])) continue;
      state.near[state.near_count++] = p;
    }
  }
  std::copy(step.u, step.u + state.near_u.size(), state.near_u.begin());
  state.near_time = step.begin;
  if (!moves) return;
  state.near_centre = box.center();
  state.near_radius = 0.5 * box.diagonal().norm();
}

/// Points that are not listed don't touch in this step, wherever it takes them.
void listNear(const RigidStep& step, RigidState& state) {
  const double reach = step.bodies.row_sum * look_ahead;
  if (state.near_count >= 0 && farthestWay(step, state) <= reach) return;
  findNear(step, reach, state);
  if (!(farthestWay(step, state) <= reach)) findNear(step, RigidShape::away, state);
}

/// A point that does not touch.
void letGo(const RigidStep& step, int p, RigidState& state) {
  step.push(step.bodies.vertex[p], -lanesOf(state.force[p]));
  state.force[p] = {};
  state.normal[p].setZero();
}

/// The last step's force, turned with the body, acts from the start.
void carryOver(const RigidStep& step, const BodyPlace& from, const BodyPlace& to, const RigidBody& body, RigidRow& row,
               RigidState& state) {
  const Vector4f old = lanesOf(state.force[row.point]);
  const Vector4f turned =
      body.motion.moves() ? lanesOf(Vec3(to.turn * (from.turn.transpose() * toVec3(state.force[row.point])))) : old;
  const float along = row.normal.dot(turned);
  row.friction = static_cast<float>(body.friction);
  row.force = std::max(0.0F, along);
  row.stick = row.tangential = row.friction > 0 ? Vector4f(turned - along * row.normal) : Vector4f::Zero();
  step.push(step.bodies.vertex[row.point], row.force * row.normal + row.tangential - old);
}

/// A point's row where it touches a body, or nearly. @return whether it does
bool makeRow(const RigidStep& step, const RigidBody& body, const BodyPlace& from, const BodyPlace& to, int p,
             RigidState& state, RigidRow& row) {
  const int v = step.bodies.vertex[p];
  const Vec3 start = skinPosition(step.skin, v, step.u);
  row.predicted = step.wayOf(v);
  const Vec3 way = row.predicted.head<3>().cast<double>(), end = start + way;
  const bool moves = body.motion.moves();
  const Vec3 local_start = moves ? from.toBody(start) : start, local_end = moves ? to.toBody(end) : end;
  Vec3 normal, normal_before;
  double gap = body.shape.gapAt(local_end, normal);
  const double correction = static_cast<double>(step.bodies.correction[p]);
  const bool known = gap < RigidShape::away;
  double before = known && !(gap + correction < near_gap) ? gap : body.shape.gapAt(local_start, normal_before);
  if (!known && before < RigidShape::away) {  // a long step: as if the surface went on straight
    normal = normal_before.normalized();
    gap = before + normal.dot(moves ? Vec3(local_end - local_start) : way);
  }
  if (!(before < RigidShape::away)) before = gap;  // it comes back from far out: slowly
  gap += correction;
  before += correction;
  if (!(gap < near_gap)) return false;  // nor where it is not a number
  // Along the normal of where the point was, as solveContact's: what slides gains no energy.
  const Vec3 out = known ? body.shape.normalAt(local_end, normal) : normal;
  const Vec3 along = state.normal[p].isZero() ? out : state.normal[p].cast<double>();
  state.normal[p] = out.cast<float>();
  row.point = p;
  row.normal = lanesOf(moves ? Vec3(to.turn * along) : along);
  row.body_increment = moves ? lanesOf(Vec3(end - from.toWorld(local_end))) : Vector4f::Zero();
  row.gap = static_cast<float>(gap);
  row.highest = before < 0 ? static_cast<float>(before + fastest_return) : static_cast<float>(RigidShape::away);
  row.stiffness = static_cast<float>(step.bodies.stiffness) * step.bodies.area[p];
  row.mobility = step.alpha * compliance(step.skin, v, step.inverse_mass);
  carryOver(step, from, to, body, row, state);
  return true;
}

/// The points that touch, or nearly, as rows. @return how many
int findRows(const RigidStep& step, RigidState& state) {
  int count = 0, k = 0;
  for (std::size_t b = 0; b < step.bodies.body.size(); ++b) {
    const RigidBody& body = step.bodies.body[b];
    const BodyPlace from(body, step.begin), to(body, step.end);
    for (; k < state.near_count && state.near[k] < body.end; ++k) {
      RigidRow& row = state.row[count];
      row.body = static_cast<int>(b);
      if (makeRow(step, body, from, to, state.near[k], state, row))
        ++count;
      else
        letGo(step, state.near[k], state);
    }
  }
  return count;
}

/// Solves one point's law with all other forces held; returns the change of its force, N.
/// @param changed  receives the square of that, too
Vector4f updateRow(RigidRow& row, const Vector4f& increment, float& changed) {
  const float K = row.stiffness, A = row.mobility;
  const float now = row.gap + row.normal.dot(increment - row.predicted);
  const float free = now - A * row.force;  // the gap without this force
  const float law = -K / (1 + K * A) * free, most = (row.highest - free) / A;
  const float force = std::max(0.0F, std::min(law, most));
  const float pressed = force - row.force;
  const Vector4f change = pressed * row.normal;
  row.force = force;
  changed += pressed * pressed;
  if (row.friction == 0) return change;
  Vector4f slip = increment - row.body_increment;
  slip -= row.normal.dot(slip) * row.normal;
  const Vector4f tangential = frictionForce(row.stick, slip, row.tangential, K, A, row.friction * force);
  const Vector4f dragged = tangential - row.tangential;
  row.tangential = tangential;
  changed += dragged.squaredNorm();
  return change + dragged;
}

void sweep(const RigidStep& step, int count, RigidState& state) {
  bool settled = count == 0;
  for (int s = 0; s < most_sweeps && !settled; ++s) {
    float changed = 0, size = 0;
    for (int k = 0; k < count; ++k) {
      RigidRow& row = state.row[s % 2 == 0 ? k : count - 1 - k];
      const int v = step.bodies.vertex[row.point];
      const Vector4f change = updateRow(row, step.wayOf(v), changed);
      size += row.force * row.force + row.tangential.squaredNorm();
      step.push(v, change);
    }
    settled = changed <= settled_change * settled_change * size;
  }
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

RigidLoads solveRigidBodies(const RigidBodies& bodies, const SkinModel& skin, double begin, double end, double alpha,
                            const float* inverse_mass, const Float4* u, Float4* du, RigidState& state) {
  const RigidStep step{bodies, skin, begin, end, static_cast<float>(alpha), inverse_mass, u, du};
  const bool listed = state.near_count >= 0;
  for (int k = 0; k < (listed ? state.near_count : bodies.pointCount()); ++k) {
    const int p = listed ? state.near[k] : k;
    step.push(bodies.vertex[p], lanesOf(state.force[p]));
  }
  listNear(step, state);
  const int count = findRows(step, state);
  sweep(step, count, state);

  RigidLoads loads;
  for (int k = 0; k < count; ++k) {
    const RigidRow& row = state.row[k];
    const Vector4f force = row.force * row.normal + row.tangential;
    store(state.force[row.point], loadGroup(force.data()));
    RigidLoad& load = loads[static_cast<std::size_t>(row.body)];
    load.force += force.head<3>().cast<double>();
    load.count += row.force > 0;
    const Vector4f moved = step.wayOf(bodies.vertex[row.point]) - row.predicted;
    load.max_penetration = std::max(load.max_penetration, -static_cast<double>(row.gap + row.normal.dot(moved)));
  }
  return loads;
}

}  // namespace palpate

#include "contact/rigid_rows.h"

#include <algorithm>
#include <cmath>

#include "contact/skin_forces.h"

namespace palpate {
namespace {

using Eigen::Vector4f;

/// Of the forces: a kidney's nodes on a table tremble at 2e-6 m/s, and at a hundred times that with 1e-4, for a sweep
/// less.
constexpr float settled_on_rigid = 1e-6F;

/// m, that nodes go until points near a body are looked for anew, and that a point comes seen in a step: in a tick at
/// 1 m/s.
constexpr double look_ahead = 2e-3;

/// Whether a point gets into a body on its way, where it ends nearer to another side of it, or behind it: of a thin
/// body the gap and the normal where it ends are those of the wrong side.
/// @param side    unit, of the face that it touched; 0: none
/// @param normal  receives the unit normal of the face by which it gets in, or got in
/// @param before, gap  m, receive the gaps at the way's start and end to that face, as if it went on straight
bool getsIn(const RigidShape& shape, const Vec3& start, const Vec3& way, const Vec3& side, Vec3& normal, double& before,
            double& gap) {
  constexpr int most_looks = 32;
  constexpr double close = 1e-6;  // m
  Vec3 x = start, out;
  double g = shape.gapAt(x, out);
  if (!side.isZero(0)) {  // back to that face, also from behind the body
    if (g >= 0 && out.dot(side) < 0) g = shape.gapAt(x += (g + close) * side, out);
    for (int k = 0; k < most_looks && g < 0 && (g < -close || out.dot(side) < 0); ++k)
      g = shape.gapAt(x += std::max(-g, close) * side, out);
    normal = side;
  } else {
    const double length = way.norm();
    double gone = 0;
    for (int k = 0; k < most_looks && g > close; ++k) {  // Newton's: never too far where the body is convex
      const double slope = out.normalized().dot(way) / length;
      if (!(slope < 0)) return false;
      gone -= g / slope;
      if (!(gone < length)) return false;
      x = start + gone / length * way;
      g = shape.gapAt(x, out);
    }
    if (!(g <= close && out.dot(way) < 0)) return false;
    normal = out.normalized();
  }
  before = g + normal.dot(start - x);
  gap = before + normal.dot(way);
  return true;
}

}  // namespace

/// Where a body is at a time.
struct RigidRows::Place {
  Place(const RigidBody& body, double time) {
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

RigidRows::RigidRows(const ContactStep& step, const RigidBodies* bodies, double begin, double end, RigidState* state)
    : step_(step), bodies_(bodies), begin_(begin), end_(end), state_(state) {
  if (bodies_ == nullptr || bodies_->empty()) {
    bodies_ = nullptr;
    return;
  }
  const bool listed = state_->near_count >= 0;
  for (int k = 0; k < (listed ? state_->near_count : bodies_->pointCount()); ++k) {
    const int p = listed ? state_->near[k] : k;
    push(p, lanesOf(state_->force[p]));
  }
}

void RigidRows::push(int point, const Vector4f& f) const {
  if (!f.isZero(0)) applyForce(step_.skin, vertexOf(point), f, step_.alpha, step_.inverse_mass, step_.du);
}

/// Bound on how far a point of the skin has gone over a body since the points near it were looked for, at the end of
/// the step, m.
double RigidRows::farthestWay() const {
  float largest = 0;
  for (std::size_t i = 0; i < state_->near_u.size(); ++i) {
    const Group way = load(step_.u[i]) + load(step_.du[i]) - load(state_->near_u[i]);
    largest = std::max(largest, way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
  }
  const double of_points = bodies_->row_sum * std::sqrt(static_cast<double>(largest));
  double of_bodies = 0;
  for (const RigidBody& body : bodies_->body) {
    if (!body.motion.moves()) continue;
    const Place then(body, state_->near_time), now(body, end_);
    of_bodies = std::max(of_bodies, (then.toBody(state_->near_centre) - now.toBody(state_->near_centre)).norm() +
                                        (then.turn - now.turn).norm() * (state_->near_radius + of_points));
  }
  return of_points + of_bodies;
}

/// The points that can touch a body while nothing goes further than `reach` (m) from where it is.
void RigidRows::findNear(double reach) {
  const bool moves = bodies_->moves();
  Box3 box;
  state_->near_count = 0;
  for (const RigidBody& body : bodies_->body) {
    const Place place(body, begin_);
    for (int p = body.begin; p < body.end; ++p) {
      const Vec3 x = skinPosition(step_.skin, vertexOf(p), step_.u);
      if (moves) box.extend(x);
      if (body.shape.leastGap(place.toBody(x)) > look_ahead + reach && isZero(state_->force[p])) continue;
      state_->near[state_->near_count++] = p;
    }
  }
  std::copy(step_.u, step_.u + state_->near_u.size(), state_->near_u.begin());
  state_->near_time = begin_;
  if (!moves) return;
  state_->near_centre = box.center();
  state_->near_radius = 0.5 * box.diagonal().norm();
}

/// Points that are not listed don't touch in this step, wherever it takes them.
void RigidRows::listNear() {
  const double reach = bodies_->row_sum * look_ahead;
  if (state_->near_count >= 0 && farthestWay() <= reach) return;
  findNear(reach);
  if (!(farthestWay() <= reach)) findNear(RigidShape::away);
}

/// A point that does not touch.
void RigidRows::letGo(int point) {
  push(point, -lanesOf(state_->force[point]));
  state_->force[point] = {};
  state_->normal[point].setZero();
}

/// The last step's force, turned with the body, acts from the start.
void RigidRows::carryOver(const RigidBody& body, const Place& from, const Place& to, RigidRow& row) {
  const Float4& last = state_->force[row.point];
  const Vector4f old = lanesOf(last);
  const Vector4f turned = body.motion.moves() ? lanesOf(Vec3(to.turn * (from.turn.transpose() * toVec3(last)))) : old;
  const float along = row.normal.dot(turned);
  row.friction = static_cast<float>(body.friction);
  row.stick = row.friction > 0 ? Vector4f(turned - along * row.normal) : Vector4f::Zero();
  row.force = std::max(0.0F, along) * row.normal + row.stick;
  push(row.point, row.force - old);
}

/// A point's row where it touches a body, or nearly. @return whether it does
bool RigidRows::makeRow(const RigidBody& body, const Place& from, const Place& to, int point, RigidRow& row) {
  const int v = vertexOf(point);
  const Vec3 start = skinPosition(step_.skin, v, step_.u);
  row.predicted = interpolateAtVertex(step_.skin, v, step_.du);
  const Vec3 going = row.predicted.head<3>().cast<double>(), end = start + going;
  const bool moves = body.motion.moves();
  const Vec3 local_start = moves ? from.toBody(start) : start, local_end = moves ? to.toBody(end) : end;
  const Vec3 way = moves ? Vec3(local_end - local_start) : going;
  const Vec3 touched = state_->normal[point].cast<double>();  // 0: it did not
  Vec3 normal, normal_before = Vec3::Zero();
  double gap = body.shape.gapAt(local_end, normal);
  const double correction = static_cast<double>(bodies_->correction[point]);
  const bool known = gap < RigidShape::away;
  // What comes fast is pushed further by its neighbours.
  const double near = std::clamp(way.norm(), static_cast<double>(near_gap), look_ahead);
  const bool far = known && !(gap + correction < near);  // all along the way
  double before = far ? gap : body.shape.gapAt(local_start, normal_before);
  bool straight = false;  // as if the surface went on straight
  if (known && !far && (touched.isZero() ? normal_before : touched).dot(normal) < 0 && before < RigidShape::away) {
    straight = getsIn(body.shape, local_start, way, touched, normal, before, gap);
  } else if (!known && before < RigidShape::away) {  // a long step
    straight = true;
    normal = normal_before.normalized();
    gap = before + normal.dot(way);
  }
  if (!(before < RigidShape::away)) before = gap;  // it comes back from far out: slowly
  gap += correction;
  before += correction;
  if (!(gap < near)) return false;  // nor where it is not a number
  // Along the normal of where the point was, as the tools' rows: what slides gains no energy.
  const Vec3 out = straight ? normal : body.shape.normalAt(local_end, normal);
  const Vec3 along = touched.isZero() ? out : touched;
  state_->normal[point] = out.cast<float>();
  row.point = point;
  row.normal = lanesOf(moves ? Vec3(to.turn * along) : along);
  row.surface = moves ? lanesOf(Vec3(end - from.toWorld(local_end))) : Vector4f::Zero();
  row.gap = static_cast<float>(gap);
  row.highest = before < 0 ? static_cast<float>(before + fastest_return) : static_cast<float>(RigidShape::away);
  row.stiffness = layerStiffness(step_, v, static_cast<double>(bodies_->area[point]));
  row.mobility = step_.alpha * compliance(step_.skin, v, step_.inverse_mass);
  carryOver(body, from, to, row);
  return true;
}

std::size_t RigidRows::makeRows() {
  if (bodies_ == nullptr) return 0;
  listNear();
  int k = 0;
  for (std::size_t b = 0; b < bodies_->body.size(); ++b) {
    const RigidBody& body = bodies_->body[b];
    const Place from(body, begin_), to(body, end_);
    for (; k < state_->near_count && state_->near[k] < body.end; ++k) {
      RigidRow& row = state_->row[count_];
      row.body = static_cast<int>(b);
      if (makeRow(body, from, to, state_->near[k], row))
        ++count_;
      else
        letGo(state_->near[k]);
    }
  }
  return count_;
}

bool RigidRows::sweep(bool forwards) {
  const auto rowAt = [&](std::size_t k) -> RigidRow& { return state_->row[k]; };
  const auto pushRow = [&](const RigidRow& row, const Vector4f& f) { push(row.point, f); };
  sweeps_.goOn(count_, rowAt, pushRow);
  sweeps_.sweepRows(
      count_, forwards, rowAt,
      [&](const RigidRow& row) { return interpolateAtVertex(step_.skin, vertexOf(row.point), step_.du); }, pushRow);
  return sweeps_.end(settled_on_rigid);
}

RigidLoads RigidRows::finish() {
  RigidLoads loads;
  for (std::size_t k = 0; k < count_; ++k) {
    const RigidRow& row = state_->row[k];
    store(state_->force[row.point], loadGroup(row.force.data()));
    RigidLoad& load = loads[static_cast<std::size_t>(row.body)];
    load.force += row.force.head<3>().cast<double>();
    load.count += row.force.isZero(0) ? 0 : 1;
    load.max_penetration = std::max(load.max_penetration, static_cast<double>(row.penetration));
  }
  return loads;
}

}  // namespace palpate

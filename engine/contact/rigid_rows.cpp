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

/// m, that nodes go until points near a body are looked for anew: in a tick at 1 m/s.
constexpr double look_ahead = 2e-3;

/// Unit, outward, of the faces around a vertex as they are; some 20 interpolations.
Vec3 skinNormal(const SkinModel& skin, int v, const Float4* u) {
  const SkinTopology& topology = *skin.topology;
  Vec3 sum = Vec3::Zero();
  for (int k = topology.face_begin[v]; k < topology.face_begin[v + 1]; ++k) {
    const auto& [a, b, c] = skin.surface.triangles[topology.face_of[k]];
    const Vec3 at = skinPosition(skin, a, u);
    sum += (skinPosition(skin, b, u) - at).cross(skinPosition(skin, c, u) - at);
  }
  return sum.normalized();
}

/// For x in a shape whose nearest face is another than the one that it came by: the gap, m, by what it meets on its way
/// out along a unit direction; `away` where that is no face across the direction, or too far.
/// @param normal  unit, there
double gapAlong(const RigidShape& shape, const Vec3& x, const Vec3& out, Vec3& normal) {
  constexpr double across = 0.5;                                // cosine of the face's normal to the direction
  constexpr double least_step = RigidShape::farthest_out / 32;  // along a side that is near
  double way = 0, gap = shape.gapAt(x, normal);
  while (gap < 0) {
    way += std::max(-gap, least_step);
    if (way > RigidShape::farthest_out) return RigidShape::away;
    gap = shape.gapAt(x + way * out, normal);
  }
  if (!(gap < RigidShape::away)) return RigidShape::away;
  normal = shape.normalAt(x + way * out, normal);
  const double along = normal.dot(out);
  return along < across ? RigidShape::away : gap - way * along;
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
      if (body.shape.leastGap(place.toBody(x)) > near_gap + reach && isZero(state_->force[p])) continue;
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

/// What lies flat under an edge that goes over it is not met by the side beyond the edge: a point in a body goes out by
/// the face that it looks at, or that it touched. (A box drawn over a block without friction, 3 mm deep, was held by
/// three times its normal force.)
/// @param out  unit, of the face that is nearest; of its own, where that is another
/// @return  m, the gap by its own face; `away`: it is only beside one
double RigidRows::gapByOwnFace(const RigidShape& shape, int point, const Vec3& local, const Place& to, double gap,
                               Vec3& out) const {
  constexpr double faced = 0.7;  // cosine: faces that meet at less are of one smooth surface
  const Vec3f& touched = state_->normal[point];
  if (shape.kind == RigidShape::Kind::HalfSpace || shape.kind == RigidShape::Kind::Sphere) return gap;
  if (gap >= 0 && !touched.isZero()) return gap;
  const Vec3 own = touched.isZero() ? Vec3(to.turn.transpose() * -skinNormal(step_.skin, vertexOf(point), step_.u))
                                    : Vec3(touched.cast<double>());
  if (out.dot(own) >= faced) return gap;
  if (gap >= 0) return RigidShape::away;
  Vec3 normal;
  const Vec3 along_side = (own - own.dot(out) * out).normalized();
  const double by_own = gapAlong(shape, local, along_side, normal);
  if (!(by_own < RigidShape::away) || normal.dot(own) <= out.dot(own)) return gap;
  out = normal;
  return by_own;
}

/// A point's row where it touches a body, or nearly. @return whether it does
bool RigidRows::makeRow(const RigidBody& body, const Place& from, const Place& to, int point, RigidRow& row) {
  const int v = vertexOf(point);
  const Vec3 start = skinPosition(step_.skin, v, step_.u);
  row.predicted = interpolateAtVertex(step_.skin, v, step_.du);
  const Vec3 going = row.predicted.head<3>().cast<double>(), end = start + going;
  const bool moves = body.motion.moves();
  const Vec3 local_start = moves ? from.toBody(start) : start, local_end = moves ? to.toBody(end) : end;
  Vec3 normal, normal_before;
  double gap = body.shape.gapAt(local_end, normal);
  const double correction = static_cast<double>(bodies_->correction[point]);
  const bool known = gap < RigidShape::away;
  double before = known && !(gap + correction < near_gap) ? gap : body.shape.gapAt(local_start, normal_before);
  if (!known && before < RigidShape::away) {  // a long step: as if the surface went on straight
    normal = normal_before.normalized();
    gap = before + normal.dot(moves ? Vec3(local_end - local_start) : going);
  }
  if (!(before < RigidShape::away)) before = gap;  // it comes back from far out: slowly
  Vec3 out = normal;
  if (known && gap < near_gap) {
    out = body.shape.normalAt(local_end, normal);
    const double own = gapByOwnFace(body.shape, point, local_end, to, gap, out);
    if (own != gap) before = gap = own;
  }
  gap += correction;
  before += correction;
  if (!(gap < near_gap)) return false;  // nor where it is not a number
  // Along the normal of where the point was, as the tools' rows: what slides gains no energy.
  const Vec3 along = state_->normal[point].isZero() ? out : state_->normal[point].cast<double>();
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
  SweepChange change;
  sweepRows(
      count_, forwards, change, [&](std::size_t k) -> RigidRow& { return state_->row[k]; },
      [&](const RigidRow& row) { return interpolateAtVertex(step_.skin, vertexOf(row.point), step_.du); },
      [&](const RigidRow& row, const Vector4f& f) { push(row.point, f); });
  return change.isSettled(settled_on_rigid);
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

#include "contact/tool_rows.h"

#include <algorithm>
#include <cmath>

#include "contact/samples/face_samples.h"
#include "contact/skin_forces.h"
#include "contact/tool_side.h"

namespace palpate {
namespace {

using Eigen::Vector4f;

/// Squared length of a remembered side (a unit vector otherwise) from which on it says that the tool came from inside.
constexpr float passing = 2;

/// Bound on a sample's: its corners move each other no more than themselves. Too large a response makes the sweeps
/// careful, not wrong.
float compliance(const SkinModel& skin, const SkinPoint& sample, const float* inverse_mass) {
  float root = 0;
  for (int c = 0; c < sample.corners; ++c)
    root += sample.share[c] * std::sqrt(compliance(skin, sample.vertex[c], inverse_mass));
  return root * root;
}

Vector4f interpolateAt(const ContactStep& step, int vertex, const SkinPoint* sample, const Float4* field) {
  return sample == nullptr ? interpolateAtVertex(step.skin, vertex, field) : interpolate(step.skin, *sample, field);
}

void push(const ContactStep& step, int vertex, const SkinPoint* sample, const Vector4f& f) {
  if (sample == nullptr) return applyForce(step.skin, vertex, f, step.alpha, step.inverse_mass, step.du);
  for (int c = 0; c < sample->corners; ++c)
    applyForce(step.skin, sample->vertex[c], sample->share[c] * f, step.alpha, step.inverse_mass, step.du);
}

/// Whether a tool that comes to the skin at vertex v would push it along `way`, outwards: it comes from inside then,
/// and passes, or it would carry the skin off. Cosine beyond which that is so: a tool in a dent touches its walls
/// sideways.
bool comesFromInside(const SkinModel& skin, int v, const Vec3& way, const Float4* u) {
  constexpr double outwards = 0.5;
  if (skin.topology->face_begin.empty()) return false;
  Vec3 outside = Vec3::Zero();
  for (int k = skin.topology->face_begin[v]; k < skin.topology->face_begin[v + 1]; ++k) {
    const auto& corner = skin.surface.triangles[skin.topology->face_of[k]];
    const Vec3 x = skinPosition(skin, corner[0], u);
    outside += (skinPosition(skin, corner[1], u) - x).cross(skinPosition(skin, corner[2], u) - x);
  }
  return way.dot(outside) > outwards * outside.norm();
}

}  // namespace

ToolRows::Motion::Motion(const Pose& from, const Pose& to)
    : world_from_tool(to.orientation.toRotationMatrix()),
      world_from_old_tool(from.orientation.toRotationMatrix()),
      turn(world_from_tool * world_from_old_tool.transpose()),
      position(to.position),
      old_position(from.position) {}

ToolRows::Body::Body(TouchingTool& touching)
    : tool(&touching), motion(touching.previous_pose, touching.pose), profile(toolProfile(*touching.shape)) {
  if (tool->hold != nullptr) given = tool->hold->way + tool->hold->opening * tool->apart;
}

Vector4f ToolRows::Body::turned(const Float4& force) const { return lanesOf(Vec3(motion.turn * toVec3(force))); }

void ToolRows::Body::follow() { shift = lanesOf(tool->hold->way + tool->hold->opening * tool->apart - given); }

ToolRows::ToolRows(const ContactStep& step, std::span<TouchingTool> tools) : step_(step), count_(tools.size()) {
  for (std::size_t b = 0; b < count_; ++b) {
    const Body& body = body_[b].emplace(tools[b]);
    const ContactState& contact = *body.tool->contact;
    for (int slot = 0; slot < contact.count; ++slot)
      push(step, contact.vertex[slot], nullptr, body.turned(contact.force[slot]));
    const FaceSamples& samples = contact.samples;
    for (int slot = 0; slot < samples.count; ++slot)
      push(step, 0, &samples.point[slot], body.turned(samples.force[slot]));
  }
}

std::size_t ToolRows::makeRows() {
  std::size_t rows = 0;
  for (std::size_t b = 0; b < count_; ++b) {
    makeRows(*body_[b]);
    rows += body_[b]->row_count;
  }
  return rows;
}

/// The vertices that touch, or nearly, then the samples of stretched faces.
void ToolRows::makeRows(Body& body) {
  const SkinModel& skin = step_.skin;
  const Motion& motion = body.motion;
  ContactState& contact = *body.tool->contact;
  FaceSamples& samples = contact.samples;
  const auto cap = static_cast<float>(most_depths * skin.layer_depth);
  body.row_count = 0;
  for (int k = 0; k < contact.count + samples.count; ++k) {
    const bool is_vertex = k < contact.count;
    const int slot = is_vertex ? k : k - contact.count;
    const SkinPoint* const sample = is_vertex ? nullptr : &samples.point[slot];
    const int v = is_vertex ? contact.vertex[slot] : sample->vertex[0];
    Float4& last_force = (is_vertex ? contact.force : samples.force)[slot];
    Vec3f& last_normal = (is_vertex ? contact.normal : samples.normal)[slot];
    Vec3f& side = (is_vertex ? contact.side : samples.side)[slot];

    const Vector4f predicted = interpolateAt(step_, v, sample, step_.du);
    const Vec3 start = is_vertex ? skinPosition(skin, v, step_.u) : skinPosition(skin, *sample, step_.u);
    const Vec3 end = start + predicted.head<3>().cast<double>();
    const Vec3 local = motion.world_from_tool.transpose() * (end - motion.position);
    const Vec3 old_local = motion.world_from_old_tool.transpose() * (start - motion.old_position);
    if (side.squaredNorm() > passing) {  // the tool came to it from inside, and it is left alone until it has passed
      if (toolDistance(body.profile, local).distance <= near_gap) continue;
      side.setZero();
    }
    ToolDistance d = distanceBySide(body.profile, local, old_local, last_normal, side);
    if (!is_vertex) d.distance += static_cast<double>(samples.lift[slot]);
    const Vector4f applied = body.turned(last_force);
    const bool touches = d.distance <= near_gap;  // not where it is not a number
    const bool from_inside =
        touches && last_normal.isZero() && comesFromInside(skin, v, motion.world_from_tool * d.normal, step_.u);
    if (!touches || from_inside) {
      push(step_, v, sample, -applied);
      last_force = Float4{};
      last_normal.setZero();
      side = from_inside ? Vec3f(2, 0, 0) : Vec3f::Zero();
      continue;
    }
    ToolRow& row = body.tool->scratch->row[body.row_count++] = ToolRow{};
    row.slot = slot;
    row.vertex = v;
    row.sample = sample;
    row.gap = static_cast<float>(d.distance);
    row.predicted = predicted;
    row.surface = lanesOf(Vec3(end - (motion.world_from_old_tool * local + motion.old_position)));
    row.stiffness = layerStiffness(step_, v, is_vertex ? skin.area[v] : static_cast<double>(samples.area[slot]));
    row.largest = cap * row.stiffness;
    row.friction = static_cast<float>(body.tool->friction);
    row.mobility = step_.alpha * (is_vertex ? compliance(skin, v, step_.inverse_mass)
                                            : compliance(skin, *sample, step_.inverse_mass));

    // Along the normal of where the point was at the step's start, so that what slides over the tool gains no energy.
    // Along the one of where it will be, a force that stays pushes it on, both ways: by N |du|^2 / R a step.
    const bool touched = !last_normal.isZero();
    row.normal = lanesOf(Vec3(motion.world_from_tool * (touched ? Vec3(last_normal.cast<double>()) : d.normal)));
    row.force = applied;
    row.stick = applied - row.normal.dot(applied) * row.normal;
    last_normal = d.normal.cast<float>();
  }
}

/// Calls `call(giving)` for what may give way: tools as a whole, and jaws.
template <class Call>
void ToolRows::forEachGiving(Call call) {
  for (std::size_t b = 0, end = 0; b < count_; b = end) {
    ToolHold* hold = body_[b]->tool->hold;
    for (end = b + 1; end < std::min(count_, body_.size()) && body_[end]->tool->hold == hold && hold != nullptr;) ++end;
    if (hold == nullptr) continue;
    const Bodies own(&body_[b], end - b);
    call(Giving{own, false, hold->max_force});
    if (hold->max_pinch > 0) call(Giving{own, true, hold->max_pinch});
  }
}

bool ToolRows::sweep(bool forwards) {
  const auto pushRow = [&](const ToolRow& row, const Vector4f& f) { push(step_, row.vertex, row.sample, f); };
  const auto rowOf = [](const Body& body) { return [&body](std::size_t k) -> ToolRow& { return body.rows()[k]; }; };
  for (std::size_t b = 0; b < count_; ++b) sweeps_.goOn(body_[b]->row_count, rowOf(*body_[b]), pushRow);
  for (std::size_t b = 0; b < count_; ++b) {
    const Body& body = *body_[forwards ? b : count_ - 1 - b];
    sweeps_.sweepRows(
        body.row_count, forwards, rowOf(body),
        [&](const ToolRow& row) -> Vector4f {
          return interpolateAt(step_, row.vertex, row.sample, step_.du) - body.shift;
        },
        pushRow);
  }
  bool settled = sweeps_.end(step_.settled);
  forEachGiving([&](const Giving& giving) { settled &= giveWay(giving); });
  return settled;
}

void ToolRows::Giving::measure() {
  Vec3 on_tool = Vec3::Zero();
  size = 0;
  for (const auto& body : bodies) {
    Vec3 force = Vec3::Zero();
    for (const ToolRow& row : body->rows()) force -= row.force.head<3>().cast<double>();
    on_tool += force;
    size += force.dot(body->tool->apart);  // half of what presses a finger away from the other
  }
  if (opens) return;
  size = on_tool.norm();
  out = size > 0 ? Vec3(on_tool / size) : Vec3::Zero();
}

/// All forces that the tool feels times `share`.
void ToolRows::scale(const Giving& giving, float share) {
  for (const auto& body : giving.bodies)
    for (ToolRow& row : body->rows()) {
      push(step_, row.vertex, row.sample, (share - 1) * row.force);
      row.force *= share;
    }
}

/// m, that the tool must go for its layer to carry the forces as they are, on the mean.
double ToolRows::distance(const Giving& giving) const {
  double excess = 0, weight = 0;
  for (const auto& body : giving.bodies) {
    const Vector4f way = lanesOf(giving.along(*body));
    for (const ToolRow& row : body->rows()) {
      const float force = row.normal.dot(row.force);
      if (force <= 0) continue;
      const Vector4f moved = interpolateAt(step_, row.vertex, row.sample, step_.du) - body->shift - row.predicted;
      const float penetration = -(row.gap + row.normal.dot(moved));
      excess += static_cast<double>(force * (penetration - force / row.stiffness));
      weight -= static_cast<double>(force * row.normal.dot(way));
    }
  }
  return weight > 0 ? excess / weight : 0;
}

/// Lets a tool give way where its hand bears more than it can, or come back where it bears less.
/// @return whether that is as it should be already
bool ToolRows::giveWay(Giving giving) {
  constexpr double close = 0.02, most_growth = 1.5;  // of the limit; of the forces in one sweep
  ToolHold& hold = *giving.bodies.front()->tool->hold;
  giving.measure();
  const bool gave = giving.opens ? hold.opening > 0 : !hold.way.isZero(0);
  if (giving.limit <= 0 || (giving.size <= giving.limit && !gave)) return true;
  sweeps_.startAnew();
  double t = 0;
  if (giving.size > 0) {
    scale(giving, static_cast<float>(std::min(giving.limit / giving.size, most_growth)));
    t = distance(giving);
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

void ToolRows::finish() {
  forEachGiving([&](Giving giving) {  // what is left, and no hand bears
    giving.measure();
    if (giving.limit > 0 && giving.size > giving.limit) scale(giving, static_cast<float>(giving.limit / giving.size));
  });
  for (std::size_t b = 0; b < count_; ++b) {
    const Body& body = *body_[b];
    ContactState& contact = *body.tool->contact;
    contact.max_penetration = 0;
    contact.contact_count = 0;
    body.tool->force.setZero();
    for (const ToolRow& row : body.rows()) {
      store((row.sample == nullptr ? contact.force : contact.samples.force)[row.slot], loadGroup(row.force.data()));
      body.tool->force -= row.force.head<3>().cast<double>();
      contact.max_penetration = std::max(contact.max_penetration, static_cast<double>(row.penetration));
      contact.contact_count += row.force.isZero(0) ? 0 : 1;
    }
  }
}

}  // namespace palpate

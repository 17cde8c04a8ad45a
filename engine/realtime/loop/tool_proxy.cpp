#include "realtime/loop/tool_proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/skin.h"
#include "step/tool_contact.h"
#include "step/trust.h"

namespace palpate {
namespace {

/// 1 up to `begin`, 0 from `end` on.
double fade(double value, double begin, double end) { return std::clamp((end - value) / (end - begin), 0.0, 1.0); }

/// m/s, in the softest material at rest.
double slowestSound(const Model& model) {
  double slowest = std::numeric_limits<double>::infinity();
  for (const Material& m : model.materials) slowest = std::min(slowest, std::sqrt(m.waveModulus() / m.density));
  return slowest;
}

/// `move` without a part of what goes against `out`, one of the two components of the tissue's unit push on the tool.
/// @param share  what is left of it, 0 .. 1, where the component is no small one
Vec3 held(const Vec3& move, const Vec3& out, double share) {
  constexpr double small = 0.5;  // of the push: below, the tissue is hardly in this way
  const double size = out.norm(), against = size > 0 ? -move.dot(out) / size : 0;
  if (against <= 0) return move;
  return move + (1 - share) * std::min(1.0, size / small) * against / size * out;
}

}  // namespace

ToolProxy::ToolProxy(const Model& model, int tool)
    : model_(model),
      at_(&model),
      tool_(tool),
      max_speed_(model.tools.tool[static_cast<std::size_t>(tool)].max_speed),
      arrival_ticks_(static_cast<int>(std::lround(arrival_seconds * model.scene.dynamics.rate_hz))),
      max_advance_(YieldLimits::sound_share * slowestSound(model) / model.scene.dynamics.rate_hz),
      snag_(model, tool),
      skin_scratch_(model.skin.surface.vertices.size()) {}

void ToolProxy::beGentle() {
  memory_.gentle = true;
  memory_.arrived_ticks = 0;
  memory_.lets_go = false;
}

double ToolProxy::freedom(const StepReport& last) const {
  const double radius = model_.scene.tools[0].shape.radius;
  return std::min(fade(-static_cast<double>(last.min_J), -TrustLimits::min_J, -YieldLimits::min_J),
                  fade(last.max_penetration, TrustLimits::penetration * radius, YieldLimits::penetration * radius));
}

double ToolProxy::freedomToDraw(const State& state) const {
  float stretch = 1;
  for (std::size_t b = 0; b < model_.tools.body.size(); ++b)
    if (model_.tools.body[b].tool == tool_) stretch = std::max(stretch, state.contact[b].samples.largest_stretch);
  return fade(static_cast<double>(stretch), YieldLimits::free_stretch, YieldLimits::stretch);
}

Vec3 ToolProxy::drawnWay(const State& state) const {
  Vec3 sum = Vec3::Zero(), body = Vec3::Zero();
  double weight = 0;
  for (std::size_t b = 0; b < model_.tools.body.size(); ++b) {
    if (model_.tools.body[b].tool != tool_) continue;
    forEachContactForce(state.contact[b], [&](int vertex, const Float4& force) {
      const double size = toVec3(force).norm();
      sum += size * (skinPosition(at_->skin, vertex, state.u.data()) - at_->skin.surface.vertices[vertex]);
      weight += size;
    });
  }
  if (!(weight > 0)) return Vec3::Zero();
  for (const Float4& u : state.u) body += toVec3(u);
  return (sum / weight - body / static_cast<double>(state.u.size())).normalized();
}

double ToolProxy::yieldAfter(const Pose& hand, const State& state, const StepReport& report) const {
  constexpr double at_limit = 0.95;  // of it
  const bool gave_way =
      model_.tools.first().max_force > 0 && report.tool_force.norm() > at_limit * model_.tools.first().max_force;
  return gave_way || report.loads[0].stopped ? (hand.position - state.tool[0].pose.position).norm() : yield_;
}

/// While it lets go: it has come to its hand, no skin is near it, and it is in no tissue. Looks now and then.
bool ToolProxy::isOutside(const State& state, const Vec3& hand, const StepReport& last) {
  constexpr double look_seconds = 0.05;
  const Vec3& tip = state.tool[tool_].pose.position;
  const auto every = std::max(1, static_cast<int>(look_seconds * model_.scene.dynamics.rate_hz));
  if (++memory_.let_go_ticks % every != 0 || last.loads[static_cast<std::size_t>(tool_)].near_count > 0 ||
      (hand - tip).norm() > max_speed_ / model_.scene.dynamics.rate_hz)
    return false;
  return !isInside(at_->skin, state.u.data(), tip, skin_scratch_);
}

void ToolProxy::letGoWhereStuck(const State& state, const Vec3& hand, const StepReport& last) {
  if (memory_.lets_go) {
    if (isOutside(state, hand, last)) beGentle();
  } else if (snag_.update(state, hand)) {
    memory_.lets_go = true;
    memory_.let_go_ticks = 0;
  }
}

ToolPosture ToolProxy::follow(const ToolPosture& hand, const State& state, const StepReport& last) {
  letGoWhereStuck(state, hand.pose.position, last);
  if (memory_.lets_go) {
    yield_ = 0;
    return hand;
  }
  const ToolLoad& load = last.loads[static_cast<std::size_t>(tool_)];
  return {followFrom(state, hand.pose, load.force, last), followOpening(hand.opening, state, last)};
}

double ToolProxy::followOpening(double wanted, const State& state, const StepReport& last) const {
  const double opening = state.tool[tool_].opening;
  const double pinch = last.loads[static_cast<std::size_t>(tool_)].pinch;
  const double reach = (pinch > 0 ? std::min(closing_speed, max_speed_) : max_speed_) / model_.scene.dynamics.rate_hz;
  double change = std::clamp(wanted - opening, -reach, max_speed_ / model_.scene.dynamics.rate_hz);
  if (change < 0 && pinch > 0) {
    const double g = freedom(last);
    change *= g * g;
  }
  return opening + change;
}

Vec3 ToolProxy::inOneTick(const Vec3& move) const {
  const double reach = max_speed_ / model_.scene.dynamics.rate_hz;
  return move.norm() > reach ? Vec3(reach / move.norm() * move) : move;
}

Pose ToolProxy::followFrom(const State& state, const Pose& hand, const Vec3& force, const StepReport& last) {
  const ToolPosture& from = state.tool[tool_];
  const bool touches = !force.isZero(0);
  Pose pose = yieldFrom(from.pose, hand, force, touches ? freedom(last) : 1);
  if (const double draws = touches ? freedomToDraw(state) : 1; draws < 1) {
    const Vec3 way = drawnWay(state), move = inOneTick(pose.position - from.pose.position);
    if (const double further = move.dot(way); further > 0) {
      pose.position = from.pose.position + move - (1 - draws * draws) * further * way;
      yield_ = (hand.position - pose.position).norm();
      memory_.arrived_ticks = 0;
    }
  }
  return pose;
}

Pose ToolProxy::yieldFrom(const Pose& from, const Pose& hand, const Vec3& force, double g) {
  const bool touches = !force.isZero(0);
  const double share = g * g;
  yield_ = 0;
  const Vec3 axis = from.orientation * Vec3::UnitZ();
  const Vec3 out = touches ? Vec3(force.normalized()) : axis;
  const double tick_s = 1 / model_.scene.dynamics.rate_hz;
  const Vec3 way = hand.position - from.position;
  const bool too_fast = touches && tick_s * max_speed_ > max_advance_ && -way.dot(out) > max_advance_;
  if (share >= 1 && !memory_.gentle && !too_fast) return hand;

  Vec3 move = way;
  const double reach = tick_s * (memory_.gentle && !touches ? approach_speed : max_speed_);
  if (move.norm() > reach) move *= reach / move.norm();
  const bool deeper = move.dot(out) < 0;
  const double gently = tick_s * gentle_speed;
  move = held(held(move, out.dot(axis) * axis, share), out - out.dot(axis) * axis, share);
  if (memory_.gentle && touches && deeper && move.norm() > gently) move *= gently / move.norm();
  if (too_fast) move += std::max(0.0, -move.dot(out) - max_advance_) * out;

  Pose pose;
  const bool arrives = move == way;
  pose.position = arrives ? hand.position : Vec3(from.position + move);
  pose.orientation = share >= 1 ? hand.orientation : from.orientation.slerp(share, hand.orientation).normalized();
  memory_.arrived_ticks = arrives ? memory_.arrived_ticks + 1 : 0;
  if (memory_.arrived_ticks >= arrival_ticks_) memory_.gentle = false;
  if (!arrives) yield_ = (hand.position - pose.position).norm();
  return pose;
}

}  // namespace palpate

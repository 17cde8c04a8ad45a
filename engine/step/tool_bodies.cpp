#include "step/tool_bodies.h"

#include <algorithm>
#include <cmath>

#include "model/live_parameters.h"
#include "step/rigid_stop.h"
#include "step/tool_contact.h"
#include "step/workspace.h"

namespace palpate {
namespace {

double topSpeed(const Model& model, int tool) { return model.tools.tool[static_cast<std::size_t>(tool)].max_speed; }

/// How a body moves with its jaws' opening.
Vec3 apartOf(const ToolBody& body, const ToolPosture& tool) {
  return body.side == 0 ? Vec3::Zero() : Vec3(0.5 * body.side * (tool.pose.orientation * Vec3::UnitX()));
}

/// How the hand holds a tool that goes from where it was to `wanted`. Where it was at its limit in the last step it is
/// guessed to stay where it was. It gives no way to what a rigid body bears.
/// @param on_tissue  N, receives the tool's force in the last step
ToolHold holdOf(const Model& model, const State& state, int tool, const ToolPosture& was, const ToolPosture& wanted,
                Vec3& on_tissue) {
  constexpr double at_limit = 0.95;  // of it
  // Faster than it may follow a hand: a cell that was crushed thrusts.
  constexpr double quicker = 4;
  ToolHold hold;
  hold.longest = quicker * topSpeed(model, tool) * model.dt;
  hold.max_force = model.tools.tool[static_cast<std::size_t>(tool)].max_force;
  hold.max_pinch = model.tools.tool[static_cast<std::size_t>(tool)].grip_force;
  double pinch = 0;
  for (std::size_t b = 0; b < model.tools.body.size(); ++b) {
    const ToolBody& body = model.tools.body[b];
    if (body.tool != tool) continue;
    Vec3 force = Vec3::Zero();
    forEachContactForce(state.contact[b], [&](int, const Float4& f) { force += toVec3(f); });
    on_tissue += force;
    pinch -= force.dot(apartOf(body, was));
  }
  const RigidStop now{static_cast<double>(state.step) * model.dt};
  if (hold.max_force > 0 && !on_tissue.isZero(0) && now.bears(model, tool, was, -on_tissue)) hold.max_force = 0;
  if (hold.max_force > 0 && on_tissue.norm() > at_limit * hold.max_force) {
    const Vec3 stays = was.pose.position - wanted.pose.position;
    if (stays.dot(on_tissue) < 0) hold.way = stays;
  }
  if (hold.max_pinch > 0 && pinch > at_limit * hold.max_pinch)
    hold.opening = std::max(0.0, was.opening - wanted.opening);
  hold.longest += hold.way.norm() + hold.opening;
  return hold;
}

}  // namespace

Command restCommand(const Model& model) {
  Command command;
  command.moves_others = true;
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t) command.tools[t] = model.tools.tool[t].start;
  return command;
}

ToolPostures posturesOf(const State& state) {
  ToolPostures postures;
  std::copy(state.tool.begin(), state.tool.end(), postures.begin());
  return postures;
}

ToolPosture between(const ToolPosture& from, const ToolPosture& to, double share) {
  if (share >= 1) return to;
  ToolPosture posture;
  posture.pose.position = from.pose.position + share * (to.pose.position - from.pose.position);
  posture.pose.orientation = from.pose.orientation.slerp(share, to.pose.orientation).normalized();
  posture.opening = from.opening + share * (to.opening - from.opening);
  return posture;
}

double largestWay(const Model& model, int tool, const ToolPosture& from, const ToolPosture& to) {
  double largest = 0;
  for (const ToolBody& body : model.tools.body)
    if (body.tool == tool)
      largest = std::max(largest, largestTravel(body.shape, bodyPose(body, from), bodyPose(body, to)));
  return largest;
}

ToolWays::ToolWays(const Model& model, const State& state, const Command& command)
    : model_(model), count_(model.tools.toolCount()) {
  const ToolPostures from = posturesOf(state);
  to_ = command.moves_others ? command.tools : from;
  to_[0].pose = command.tools[0].pose;
  const double end = static_cast<double>(state.step + model.substeps_per_tick) * model.dt;
  for (int t = 0; t < count_; ++t) {
    const auto k = static_cast<std::size_t>(t);
    reach_[k] = topSpeed(model, t) / model.scene.dynamics.rate_hz;
    const double wanted = largestWay(model, t, from[k], to_[k]);
    if (wanted > reach_[k]) to_[k] = between(from[k], to_[k], reach_[k] / wanted);
    const Vec3 wanted_at = to_[k].pose.position;
    const RigidStop stop{end, model.substeps_per_tick * model.dt, reach_[k], state.region_shift};
    to_[k] = stop.of(model, t, from[k], to_[k]);
    stopped_[k] = to_[k].pose.position != wanted_at;
    fails_[k] = stop.failsAt(model, t, to_[k]);
    if (!stopped_[k]) continue;
    reach_[k] = std::max(reach_[k], largestWay(model, t, from[k], to_[k]));
  }
}

ToolPostures ToolWays::next(const State& state, int left) const {
  ToolPostures postures = posturesOf(state);
  for (std::size_t t = 0; t < static_cast<std::size_t>(count_); ++t)
    postures[t] = between(postures[t], to_[t], 1.0 / left);
  return postures;
}

void addToLoad(const ToolBody& body, const TouchingTool& felt, ToolLoads& loads) {
  ToolLoad& load = loads[static_cast<std::size_t>(body.tool)];
  load.force += felt.force;
  load.contact_count += felt.contact->contact_count;
  if (body.side != 0) load.pinch += 0.5 * body.side * felt.force.dot(felt.pose.orientation * Vec3::UnitX());
}

ContactForces solveContacts(const Model& model, ToolPostures& tools, double alpha, const float* inverse_mass,
                            ContactGroup* held, State& state, ContactWorkspace& scratch, ToolLoads& loads) {
  const ToolSet& set = model.tools;
  const std::size_t bodies = set.body.size(), count = set.tool.size();
  std::array<TouchingTool, max_tool_bodies> touching;
  std::array<ToolHold, max_tools> holds;
  std::array<Vec3, max_tools> was_on_tissue;  // N
  was_on_tissue.fill(Vec3::Zero());
  const ToolPostures before = posturesOf(state);
  for (std::size_t t = 0; t < count; ++t) {
    holds[t] = holdOf(model, state, static_cast<int>(t), before[t], tools[t], was_on_tissue[t]);
    tools[t].pose.position += holds[t].way;
    tools[t].opening += holds[t].opening;
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const ToolBody& body = set.body[b];
    const auto t = static_cast<std::size_t>(body.tool);
    touching[b] = {&body.shape,
                   bodyPose(body, tools[t]),
                   bodyPose(body, before[t]),
                   state.live.friction[t],
                   &state.contact[b],
                   &scratch.tools[b],
                   &holds[t],
                   apartOf(body, tools[t])};
  }
  const std::array<ToolHold, max_tools> guessed = holds;
  const double begin = static_cast<double>(state.step) * model.dt;
  const ContactForces forces =
      solveContacts({model.skin, static_cast<float>(alpha), inverse_mass, state.u.data(), state.du.data(),
                     settled_change, static_cast<float>(std::max(1.0, stiffening(model, state.live)))},
                    {{touching.data(), bodies},
                     held,
                     &state.skins,
                     &scratch.skins,
                     &model.rigid,
                     &state.rigid,
                     begin,
                     begin + model.dt});
  for (std::size_t t = 0; t < count; ++t) {
    tools[t].pose.position += holds[t].way - guessed[t].way;
    tools[t].opening += holds[t].opening - guessed[t].opening;
  }
  for (std::size_t b = 0; b < bodies; ++b) addToLoad(set.body[b], touching[b], loads);
  for (std::size_t t = 0; t < count; ++t)
    loads[t].work = 0.5 * (was_on_tissue[t] - loads[t].force).dot(tools[t].pose.position - before[t].pose.position);
  return forces;
}

}  // namespace palpate

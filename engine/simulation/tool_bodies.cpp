#include "simulation/tool_bodies.h"

#include <algorithm>
#include <cmath>

#include "discretization/surface/surface_tree.h"
#include "simulation/rigid_stop.h"
#include "simulation/scene_messages.h"
#include "simulation/tool_contact.h"

namespace palpate {
namespace {

/// m, along the way the tip points, of what touches first; not finite: nothing does.
double travelToSkin(const TriangleSurface& skin, const ToolSet& set, int tool, const ToolPosture& start) {
  double first = std::numeric_limits<double>::infinity();
  for (const ToolBody& body : set.body)
    if (body.tool == tool) first = std::min(first, firstContactTravel(skin, body.shape, bodyPose(body, start)));
  return first;
}

bool startsInside(const SurfaceTree& organ, const ToolSet& set, int tool, const ToolPosture& start) {
  return std::any_of(set.body.begin(), set.body.end(), [&](const ToolBody& body) {
    if (body.tool != tool) return false;
    const Pose pose = bodyPose(body, start);
    return organ.inside(pose.position) || organ.inside(pose.toWorld(Vec3(0, 0, body.shape.radius)));
  });
}

Pose startPose(const ToolSpec& spec) { return {spec.position, Quat::FromTwoVectors(-Vec3::UnitZ(), spec.direction)}; }

/// Bound on how far any point of the tool's bodies goes between two postures, m.
double largestWay(const Model& model, int tool, const ToolPosture& from, const ToolPosture& to) {
  if (model.tools.empty()) return largestTravel(model.scene.tool, from.pose, to.pose);
  double largest = 0;
  for (const ToolBody& body : model.tools.body)
    if (body.tool == tool)
      largest = std::max(largest, largestTravel(body.shape, bodyPose(body, from), bodyPose(body, to)));
  return largest;
}

double topSpeed(const Model& model, int tool) {
  return model.tools.empty() ? model.scene.tool_max_speed : model.tools.tool[static_cast<std::size_t>(tool)].max_speed;
}

/// How a body moves with its jaws' opening.
Vec3 apartOf(const ToolBody& body, const ToolPosture& tool) {
  return body.side == 0 ? Vec3::Zero() : Vec3(0.5 * body.side * (tool.pose.orientation * Vec3::UnitX()));
}

/// How the hand holds a tool that goes from where it was to `wanted`. Where it was at its limit in the last step it is
/// guessed to stay where it was.
ToolHold holdOf(const Model& model, const State& state, int tool, const ToolPosture& was, const ToolPosture& wanted) {
  constexpr double at_limit = 0.95;  // of it
  // Faster than it may follow a hand: a cell that was crushed thrusts.
  constexpr double quicker = 4;
  ToolHold hold;
  hold.longest = quicker * topSpeed(model, tool) * model.dt;
  hold.max_force = model.max_tool_force;
  if (!model.tools.empty()) {
    hold.max_force = model.tools.tool[static_cast<std::size_t>(tool)].max_force;
    hold.max_pinch = model.tools.tool[static_cast<std::size_t>(tool)].grip_force;
  }
  Vec3 on_tissue = Vec3::Zero();
  double pinch = 0;
  for (int b = 0; b < model.tools.bodyCount(); ++b) {
    const ToolBody body = toolBody(model, b);
    if (body.tool != tool) continue;
    Vec3 force = Vec3::Zero();
    forEachContactForce(contactOf(state, b), [&](int, const Float4& f) { force += toVec3(f); });
    on_tissue += force;
    pinch -= force.dot(apartOf(body, was));
  }
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

ToolSet makeToolSet(const Scene& scene, const SurfaceTree& organ, const TriangleSurface& skin) {
  ToolSet set;
  const std::vector<ToolSpec> specs = toolsOf(scene);
  if (specs.size() == 1 && !specs[0].jaws()) return set;
  for (std::size_t t = 0; t < specs.size(); ++t) {
    const ToolSpec& spec = specs[t];
    const int tool = static_cast<int>(t);
    ToolSetUp made;
    made.shape = spec.shape;
    made.jaws = spec.jaws();
    made.start = {startPose(spec), std::max(0.0, spec.opening)};
    made.max_speed = spec.max_speed;
    made.max_force = spec.max_force;
    made.grip_force = spec.grip_force;
    made.friction = spec.friction;
    if (made.jaws) {
      set.body.push_back({tool, -1, spec.shape});
      set.body.push_back({tool, 1, spec.shape});
    } else {
      set.body.push_back({tool, 0, spec.shape});
    }
    const double travel = travelToSkin(skin, set, tool, made.start);
    if (travel < 0 || startsInside(organ, set, tool, made.start))
      throw InputError(spec.place, "tool " + std::to_string(t + 1) + " starts inside the organ",
                       made.jaws ? "move its position out of it, let its direction point at it, or widen its opening"
                                 : "move its position out of it, and let its direction point at it");
    made.first_contact_travel = std::isfinite(travel) ? travel : 0;
    set.tool.push_back(std::move(made));
  }
  return set;
}

MoreTools makeMoreTools(const Model& model) {
  MoreTools more;
  const ToolSet& set = model.tools;
  if (set.empty()) return more;
  more.opening = set.tool[0].start.opening;
  for (std::size_t t = 1; t < set.tool.size(); ++t) more.posture.push_back(set.tool[t].start);
  for (std::size_t b = 1; b < set.body.size(); ++b)
    more.contact.push_back(makeContactState(model.skin, set.body[b].shape));
  return more;
}

ToolPosture startOf(const Model& model, int tool) {
  if (model.tools.empty()) return {model.tool_start, 0};
  return model.tools.tool[static_cast<std::size_t>(tool)].start;
}

Command restCommand(const Model& model) {
  Command command;
  command.tool_target = model.tool_start;
  command.moves_others = true;
  for (int t = 0; t < model.tools.toolCount() && !model.tools.empty(); ++t)
    command.tools[static_cast<std::size_t>(t)] = startOf(model, t);
  return command;
}

ToolPosture postureOf(const State& state, int tool) {
  return tool == 0 ? ToolPosture{state.tool_pose, state.more.opening}
                   : state.more.posture[static_cast<std::size_t>(tool - 1)];
}

ToolPostures posturesOf(const Model& model, const State& state) {
  ToolPostures postures;
  for (int t = 0; t < model.tools.toolCount(); ++t) postures[static_cast<std::size_t>(t)] = postureOf(state, t);
  return postures;
}

void setPostures(const Model& model, const ToolPostures& postures, State& state) {
  state.tool_pose = postures[0].pose;
  if (model.tools.empty()) return;
  state.more.opening = postures[0].opening;
  for (std::size_t t = 1; t < model.tools.tool.size(); ++t) state.more.posture[t - 1] = postures[t];
}

ToolBody toolBody(const Model& model, int body) {
  if (model.tools.empty()) return {0, 0, model.scene.tool};
  return model.tools.body[static_cast<std::size_t>(body)];
}

ToolPosture between(const ToolPosture& from, const ToolPosture& to, double share) {
  if (share >= 1) return to;
  ToolPosture posture;
  posture.pose.position = from.pose.position + share * (to.pose.position - from.pose.position);
  posture.pose.orientation = from.pose.orientation.slerp(share, to.pose.orientation).normalized();
  posture.opening = from.opening + share * (to.opening - from.opening);
  return posture;
}

ToolWays::ToolWays(const Model& model, const State& state, const Command& command)
    : model_(model), count_(model.tools.toolCount()) {
  const ToolPostures from = posturesOf(model, state);
  to_ = command.moves_others ? command.tools : from;
  to_[0].pose = command.tool_target;
  for (int t = 0; t < count_; ++t) {
    const auto k = static_cast<std::size_t>(t);
    const double reach = topSpeed(model, t) / model.scene.rate_hz;
    const double wanted = largestWay(model, t, from[k], to_[k]);
    if (wanted > reach) to_[k] = between(from[k], to_[k], reach / wanted);
    if (model.rigid.empty()) continue;
    const double end = static_cast<double>(state.step + model.substeps_per_tick) * model.dt;
    to_[k] = stoppedByRigidBodies(model, t, to_[k], end, reach);
  }
}

ToolPostures ToolWays::next(const State& state, int left) const {
  ToolPostures postures = posturesOf(model_, state);
  for (std::size_t t = 0; t < static_cast<std::size_t>(count_); ++t)
    postures[t] = between(postures[t], to_[t], 1.0 / left);
  return postures;
}

double ToolWays::reach(int body) const { return topSpeed(model_, toolBody(model_, body).tool) / model_.scene.rate_hz; }

void addToLoad(const ToolBody& body, const TouchingTool& felt, ToolLoads& loads) {
  ToolLoad& load = loads[static_cast<std::size_t>(body.tool)];
  load.force += felt.force;
  load.contact_count += felt.contact->contact_count;
  if (body.side != 0) load.pinch += 0.5 * body.side * felt.force.dot(felt.pose.orientation * Vec3::UnitX());
}

Vec3 solveToolContacts(const Model& model, ToolPostures& tools, double alpha, const float* inverse_mass, State& state,
                       ToolLoads& loads) {
  const ToolSet& set = model.tools;
  const auto bodies = static_cast<std::size_t>(set.bodyCount()), count = static_cast<std::size_t>(set.toolCount());
  std::array<ToolBody, max_tool_bodies> body;
  std::array<TouchingTool, max_tool_bodies> touching;
  std::array<ToolHold, max_tools> holds;
  const ToolPostures before = posturesOf(model, state);
  for (std::size_t b = 0; b < bodies; ++b) body[b] = toolBody(model, static_cast<int>(b));
  for (std::size_t t = 0; t < count; ++t) {
    holds[t] = holdOf(model, state, static_cast<int>(t), before[t], tools[t]);
    tools[t].pose.position += holds[t].way;
    tools[t].opening += holds[t].opening;
  }
  for (std::size_t b = 0; b < bodies; ++b) {
    const auto t = static_cast<std::size_t>(body[b].tool);
    touching[b] = {&body[b].shape,
                   bodyPose(body[b], tools[t]),
                   bodyPose(body[b], before[t]),
                   t == 0 ? state.live.friction : set.tool[t].friction,
                   &contactOf(state, static_cast<int>(b)),
                   &holds[t],
                   apartOf(body[b], tools[t])};
  }
  const std::array<ToolHold, max_tools> guessed = holds;
  solveContacts(model.skin, {touching.data(), bodies}, alpha, inverse_mass, state.u.data(), state.du.data());
  for (std::size_t t = 0; t < count; ++t) {
    tools[t].pose.position += holds[t].way - guessed[t].way;
    tools[t].opening += holds[t].opening - guessed[t].opening;
  }
  if (set.empty()) return touching[0].force;
  for (std::size_t b = 0; b < bodies; ++b) addToLoad(body[b], touching[b], loads);
  return loads[0].force;
}

}  // namespace palpate

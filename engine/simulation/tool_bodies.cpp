#include "simulation/tool_bodies.h"

#include <algorithm>
#include <cmath>

#include "discretization/surface/surface_tree.h"
#include "simulation/scene_messages.h"

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
                       made.jaws ? "move its position against its direction, or widen its opening"
                                 : "move its position against its direction");
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

ToolWays::ToolWays(const Model& model, const State& state, const Command& command)
    : model_(model),
      count_(model.tools.toolCount()),
      from_(posturesOf(model, state)),
      to_(command.moves_others ? command.tools : from_) {
  to_[0].pose = command.tool_target;
  for (int t = 0; t < count_; ++t) {
    const auto k = static_cast<std::size_t>(t);
    const double reach = topSpeed(model, t) / model.scene.rate_hz;
    const double wanted = largestWay(model, t, from_[k], to_[k]);
    share_[k] = wanted > reach ? reach / wanted : 1;
  }
}

ToolPostures ToolWays::at(int k, int n) const {
  ToolPostures postures;
  for (std::size_t t = 0; t < static_cast<std::size_t>(count_); ++t) {
    const double s = share_[t] * k / n;
    const ToolPosture &from = from_[t], &to = to_[t];
    ToolPosture& posture = postures[t];
    posture.pose.position = from.pose.position + s * (to.pose.position - from.pose.position);
    posture.pose.orientation =
        s >= 1 ? to.pose.orientation : from.pose.orientation.slerp(s, to.pose.orientation).normalized();
    posture.opening = s >= 1 ? to.opening : from.opening + s * (to.opening - from.opening);
  }
  return postures;
}

double ToolWays::reach(int body) const { return topSpeed(model_, toolBody(model_, body).tool) / model_.scene.rate_hz; }

void addToLoad(const ToolBody& body, const TouchingTool& felt, ToolLoads& loads) {
  ToolLoad& load = loads[static_cast<std::size_t>(body.tool)];
  load.force += felt.force;
  load.contact_count += felt.contact->contact_count;
  if (body.side != 0) load.pinch += 0.5 * body.side * felt.force.dot(felt.pose.orientation * Vec3::UnitX());
}

Vec3 solveToolContacts(const Model& model, const ToolPostures& tools, double alpha, const float* inverse_mass,
                       State& state, ToolLoads& loads) {
  const ToolSet& set = model.tools;
  if (set.empty())
    return solveContact(model.skin, model.scene.tool, tools[0].pose, state.tool_pose, state.live.friction, alpha,
                        inverse_mass, state.u.data(), state.du.data(), state.contact);
  std::array<TouchingTool, max_tool_bodies> touching;
  const ToolPostures before = posturesOf(model, state);
  for (std::size_t b = 0; b < set.body.size(); ++b) {
    const ToolBody& body = set.body[b];
    const auto t = static_cast<std::size_t>(body.tool);
    touching[b] = {&body.shape,
                   bodyPose(body, tools[t]),
                   bodyPose(body, before[t]),
                   t == 0 ? state.live.friction : set.tool[t].friction,
                   &contactOf(state, static_cast<int>(b)),
                   Vec3::Zero()};
  }
  solveContacts(model.skin, {touching.data(), set.body.size()}, alpha, inverse_mass, state.u.data(), state.du.data());
  for (std::size_t b = 0; b < set.body.size(); ++b) addToLoad(set.body[b], touching[b], loads);
  return loads[0].force;
}

}  // namespace palpate

#include "io/indent_script.h"

#include <algorithm>

#include "io/find_asset.h"

namespace palpate {

namespace {

constexpr double approach_speed = 0.06;  // m/s, mean; quick, but slow enough to watch
constexpr double min_approach = 0.1;     // s, also where the tool starts at the skin
constexpr double indent_seconds = 1.0;   // slow against the tissue's own swinging
constexpr double depth_per_radius = 1.2;
constexpr std::int64_t max_ticks = 1'000'000;  // 64 MB
constexpr double max_of_organ = 0.25;          // of the organ's length along the axis

}  // namespace

ToolScript indentScript(const Model& model) {
  if (!model.scene.tools[0].script.empty())
    return readToolScript(model.scene.tools[0].script, model.scene.tools[0].shape.radius);
  const Vec3 axis = model.tools.first().start.pose.orientation * -Vec3::UnitZ();  // the way the tool advances
  double low = 0, high = 0;
  for (std::size_t v = 0; v < model.skin.surface.vertices.size(); ++v) {
    const double along = model.skin.surface.vertices[v].dot(axis);
    low = v == 0 ? along : std::min(low, along);
    high = v == 0 ? along : std::max(high, along);
  }
  const double depth = std::min(depth_per_radius * model.scene.tools[0].shape.radius, max_of_organ * (high - low));
  const double approach = std::max(min_approach, model.tools.first().first_contact_travel / approach_speed);

  ToolScript script;
  script.name = "indent and hold";
  script.keyframes = {{approach, 0, {0, 0}}, {approach + indent_seconds, depth, {0, 0}}};
  return script;
}

std::optional<ToolScript> namedScript(const std::string& name, double tool_radius) {
  if (name.empty()) return {};
  return readToolScript(findToolScript(name), tool_radius);
}

ScriptTrajectory trajectoryOf(const ToolScript& script, const Model& model, int tool) {
  const ToolSetUp& of = model.tools.tool[static_cast<std::size_t>(tool)];
  return {script, of.start.pose, of.first_contact_travel, model.scene.dynamics.rate_hz,
          model.scene.tools[static_cast<std::size_t>(tool)].opening};
}

std::vector<ToolPosture> scriptWay(const ToolScript& script, const Model& model, int tool) {
  ScriptTrajectory trajectory = trajectoryOf(script, model, tool);
  if (trajectory.ticks() > max_ticks)
    throw InputError(script.end_place, "the tool script has " + std::to_string(trajectory.ticks()) + " ticks",
                     "shorten it to " + std::to_string(max_ticks));
  std::vector<ToolPosture> way(static_cast<std::size_t>(trajectory.ticks()));
  for (ToolPosture& posture : way) {
    posture.pose = trajectory.next();
    posture.opening = std::max(0.0, trajectory.opening());
  }
  return way;
}

void addToolPaths(Model& model) {
  for (std::size_t k = 1; k < model.tools.tool.size(); ++k) {
    const ToolSpec& spec = model.scene.tools[k];
    if (!spec.script.empty())
      model.tools.tool[k].path = scriptWay(readToolScript(spec.script, spec.shape.radius), model, static_cast<int>(k));
  }
}

}  // namespace palpate

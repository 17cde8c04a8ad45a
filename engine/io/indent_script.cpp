#include "io/indent_script.h"

#include <algorithm>
#include <cmath>

#include "io/find_asset.h"

namespace palpate {

namespace {

constexpr double approach_speed = 0.06;  // m/s, mean; quick, but slow enough to watch
constexpr double min_approach = 0.1;     // s, also where the tool starts at the skin
constexpr double indent_seconds = 1.0;   // slow against the tissue's own swinging
constexpr double depth_per_radius = 1.2;
constexpr double corner_seconds = 0.02;  // half the time that a change of speed takes
constexpr double max_of_organ = 0.25;    // of the organ's length along the axis

/// The same way with its corners rounded: each position the mean of those within `reach` ticks, and as many ticks
/// more at the end. No hand changes its speed within a tick, and tissue answers such a jerk with a step of force.
std::vector<Pose> rounded(std::vector<Pose> poses, long reach) {
  poses.insert(poses.end(), static_cast<std::size_t>(reach), poses.back());
  std::vector<Pose> result = poses;
  const long count = static_cast<long>(poses.size());
  for (long k = 0; k < count; ++k) {
    const long r = std::min(reach, k);
    Vec3 sum = Vec3::Zero();
    for (long j = k - r; j <= k + r; ++j) sum += poses[static_cast<std::size_t>(std::min(j, count - 1))].position;
    result[static_cast<std::size_t>(k)].position = sum / static_cast<double>(2 * r + 1);
  }
  return result;
}

}  // namespace

ToolScript indentScript(const Model& model) {
  const Vec3 axis = model.tool_start.orientation * -Vec3::UnitZ();  // the way the tool advances
  double low = 0, high = 0;
  for (std::size_t v = 0; v < model.skin.surface.vertices.size(); ++v) {
    const double along = model.skin.surface.vertices[v].dot(axis);
    low = v == 0 ? along : std::min(low, along);
    high = v == 0 ? along : std::max(high, along);
  }
  const double depth = std::min(depth_per_radius * model.scene.tool.radius, max_of_organ * (high - low));
  const double approach = std::max(min_approach, model.first_contact_travel / approach_speed);

  ToolScript script;
  script.name = "indent and hold";
  script.keyframes = {{approach, 0, {0, 0}}, {approach + indent_seconds, depth, {0, 0}}};
  return script;
}

std::optional<ToolScript> namedScript(const std::string& name, double tool_radius) {
  if (name.empty()) return {};
  return readToolScript(findToolScript(name), tool_radius);
}

std::vector<Pose> scriptPoses(const ToolScript& script, const Model& model) {
  const double rate = model.scene.rate_hz;
  const auto ticks = std::max<long>(1, std::lround(std::ceil(script.duration() * rate)));
  std::vector<Pose> poses;
  poses.reserve(static_cast<std::size_t>(ticks));
  for (long k = 1; k <= ticks; ++k)
    poses.push_back(poseAt(script, model.tool_start, model.first_contact_travel, static_cast<double>(k) / rate));
  return rounded(poses, std::lround(corner_seconds * rate));
}

}  // namespace palpate

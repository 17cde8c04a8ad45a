#include "app/indent_track.h"

#include <algorithm>
#include <cmath>

namespace palpate {

namespace {

constexpr double approach_speed = 0.06;   // m/s, mean; quick, but slow enough to watch
constexpr double indent_seconds = 1.0;    // slow against the tissue's own swinging
constexpr double depth_per_radius = 0.5;
constexpr double most_of_organ = 0.1;     // of the organ's length along the axis

/// From 0 to 1 with velocity and acceleration zero at both ends.
double smooth(double t) { return t * t * t * (10 + t * (6 * t - 15)); }

}  // namespace

std::vector<Pose> indentPoses(const Model& model) {
  const Vec3 axis = model.tool_start.orientation * -Vec3::UnitZ();  // the way the tool advances
  double low = 0, high = 0;
  for (std::size_t v = 0; v < model.skin.surface.vertices.size(); ++v) {
    const double along = model.skin.surface.vertices[v].dot(axis);
    low = v == 0 ? along : std::min(low, along);
    high = v == 0 ? along : std::max(high, along);
  }
  const double depth = std::min(depth_per_radius * model.scene.tool.radius, most_of_organ * (high - low));
  const double rate = model.scene.rate_hz;
  const double approach = std::isfinite(model.touch_travel) ? std::max(0.0, model.touch_travel) : 0.0;

  std::vector<Pose> poses;
  const auto go = [&](double from, double to, double seconds) {
    const auto ticks = std::max<long>(1, std::lround(seconds * rate));
    for (long k = 1; k <= ticks; ++k) {
      Pose pose = model.tool_start;
      pose.position += (from + (to - from) * smooth(static_cast<double>(k) / static_cast<double>(ticks))) * axis;
      poses.push_back(pose);
    }
  };
  if (approach > 0) go(0, approach, approach / approach_speed);
  go(approach, approach + depth, indent_seconds);
  return poses;
}

}  // namespace palpate

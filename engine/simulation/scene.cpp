#include "simulation/scene.h"

#include <algorithm>
#include <cmath>

#include "simulation/scene_rigid.h"

namespace palpate {

bool Region::contains(const Vec3& x, double tolerance, double surface_distance) const {
  switch (kind) {
    case Kind::HalfSpace:
      return (x - point).dot(normal) <= tolerance;
    case Kind::Box:
      return ((x - min).array() >= -tolerance).all() && ((x - max).array() <= tolerance).all();
    case Kind::Sphere:
      return (x - point).norm() <= radius + tolerance;
    case Kind::NearPlane:
      return std::abs((x - point).dot(normal)) <= distance + tolerance;
    case Kind::Cylinder: {
      const double z = (x - point).dot(normal);
      return z >= -tolerance && z <= height + tolerance && (x - point - z * normal).norm() <= radius + tolerance;
    }
    case Kind::Shell:
      return surface_distance <= distance + tolerance;
    case Kind::Point:
      break;
  }
  return false;
}

std::vector<OrganSpec> organsOf(const Scene& scene) {
  std::vector<OrganSpec> organs{scene};
  organs.insert(organs.end(), scene.further_organs.begin(), scene.further_organs.end());
  return organs;
}

double motionEnd(const Scene& scene) {
  double end = 0;
  const auto add = [&end](double duration, const LoadCurve& curve) {
    end = std::max({end, duration, curve.time.empty() ? 0 : curve.time.back()});
  };
  for (const BoundarySpec& boundary : scene.boundaries) add(boundary.duration, boundary.curve);
  for (const LoadSpec& load : scene.loads) end = std::max(end, load.end());
  for (const RigidSpec& body : scene.rigid) add(body.motion.duration, body.motion.curve);
  return end;
}

std::vector<ToolSpec> toolsOf(const Scene& scene) {
  ToolSpec first{scene.tool,           scene.tool_position,  scene.tool_direction,
                 scene.tool_max_speed, scene.tool_max_force, scene.tool_grip_force,
                 scene.friction,       scene.tool_opening,   scene.tool_script,
                 scene.place};
  for (const char* key : {"tool", "tool.position", "tool[0].position"})
    if (const auto at = scene.places.find(key); at != scene.places.end()) first.place = at->second;
  std::vector<ToolSpec> tools{first};
  tools.insert(tools.end(), scene.further_tools.begin(), scene.further_tools.end());
  return tools;
}

double smallestToolRadius(const Scene& scene) {
  double smallest = scene.tool.radius;
  for (const ToolSpec& tool : scene.further_tools) smallest = std::min(smallest, tool.shape.radius);
  for (const RigidSpec& body : scene.rigid)
    if (body.region.radius > 0) smallest = std::min(smallest, body.region.radius);
  return smallest;
}

double largestToolSpeed(const Scene& scene) {
  double largest = scene.tool_max_speed;
  for (const ToolSpec& tool : scene.further_tools) largest = std::max(largest, tool.max_speed);
  for (const RigidSpec& body : scene.rigid) largest = std::max(largest, largestSpeed(body));
  return largest;
}

}  // namespace palpate

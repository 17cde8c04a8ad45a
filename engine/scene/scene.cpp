#include "scene/scene.h"

#include <algorithm>
#include <cmath>

#include "discretization/surface/surface_geometry.h"
#include "scene/scene_rigid.h"

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

double smallestToolRadius(const Scene& scene) {
  double smallest = scene.tools[0].shape.radius;
  for (const ToolSpec& tool : scene.tools) smallest = std::min(smallest, tool.shape.radius);
  for (const RigidSpec& body : scene.rigid) {
    const double radius = body.surface ? meanRadius(*body.surface) : body.region.radius;
    if (radius > 0 && !body.encloses) smallest = std::min(smallest, radius);
  }
  return smallest;
}

double largestToolSpeed(const Scene& scene) {
  double largest = scene.tools[0].max_speed;
  for (const ToolSpec& tool : scene.tools) largest = std::max(largest, tool.max_speed);
  for (const RigidSpec& body : scene.rigid) largest = std::max(largest, largestSpeed(body));
  return largest;
}

}  // namespace palpate

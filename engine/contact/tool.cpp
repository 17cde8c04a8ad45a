#include "contact/tool.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

/// Default rim of a flat cylinder per radius: about the spacing of a skin that suits the tool.
constexpr double kDefaultEdge = 0.3;

/// Distance to the ball of `radius` around `centre`; at the centre the tool's way forward is "out".
ToolDistance ballDistance(const Vec3& centre, double radius, const Vec3& x) {
  const Vec3 r = x - centre;
  const double length = r.norm();
  if (length == 0.0) return {-radius, -Vec3::UnitZ()};
  return {length - radius, r / length};
}

ToolDistance flatCylinderDistance(const ToolShape& tool, const Vec3& x) {
  const double e = edgeRadius(tool);
  const double r = std::hypot(x.x(), x.y());
  const double half = 0.5 * tool.length;
  // In the plane through the axis: how far beyond the core's wall (a) and end (b).
  const double a = r - (tool.radius - e);
  const double b = std::abs(x.z() - half) - (half - e);
  const Vec3 outward = r > 0.0 ? Vec3(x.x() / r, x.y() / r, 0.0) : Vec3::UnitX();
  const Vec3 endward = x.z() < half ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitZ());
  if (a > 0.0 && b > 0.0) {
    const double length = std::hypot(a, b);
    return {length - e, (a * outward + b * endward) / length};
  }
  return b >= a ? ToolDistance{b - e, endward} : ToolDistance{a - e, outward};
}

double capCentre(const ToolShape& tool) { return std::max(tool.radius, tool.length - tool.radius); }

}  // namespace

double edgeRadius(const ToolShape& tool) {
  const double e = tool.edge_radius > 0.0 ? tool.edge_radius : kDefaultEdge * tool.radius;
  return std::min({e, tool.radius, 0.5 * tool.length});
}

double smoothDepth(const ToolShape& tool) {
  return tool.kind == ToolKind::FlatCylinder ? edgeRadius(tool) : tool.radius;
}

ToolDistance toolDistance(const ToolShape& tool, const Vec3& local) {
  switch (tool.kind) {
    case ToolKind::FlatCylinder:
      return flatCylinderDistance(tool, local);
    case ToolKind::Capsule: {
      const double z = std::clamp(local.z(), tool.radius, capCentre(tool));
      ToolDistance d = ballDistance({0.0, 0.0, z}, tool.radius, local);
      // On the axis between the caps the way out is sideways.
      if (d.distance == -tool.radius && z > tool.radius) d.normal = Vec3::UnitX();
      return d;
    }
    case ToolKind::Sphere:
      break;
  }
  return ballDistance({0.0, 0.0, tool.radius}, tool.radius, local);
}

double exitDistance(const ToolShape& tool, const Vec3& local, const Vec3& direction) {
  // A step as long as the distance to the surface can't pass through it.
  const double close = 1e-4 * tool.radius;
  double travelled = 0.0;
  for (int i = 0; i < 32; ++i) {
    const double depth = -toolDistance(tool, local + travelled * direction).distance;
    if (!(depth > 0.0)) break;
    travelled += depth;
    if (depth < close) break;
  }
  return travelled;
}

double tipProfile(const ToolShape& tool, double r) {
  if (!(r <= tool.radius)) return std::numeric_limits<double>::infinity();
  const double e = tool.kind == ToolKind::FlatCylinder ? edgeRadius(tool) : tool.radius;
  const double a = std::max(0.0, r - (tool.radius - e));
  return e - std::sqrt(std::max(0.0, e * e - a * a));
}

double largestTravel(const ToolShape& tool, const Pose& from, const Pose& to) {
  const double end = tool.kind == ToolKind::Sphere ? 2.0 * tool.radius : std::max(tool.length, 2.0 * tool.radius);
  const double angle = from.orientation.angularDistance(to.orientation);
  return (to.position - from.position).norm() + angle * std::hypot(end, tool.radius);
}

}  // namespace palpate

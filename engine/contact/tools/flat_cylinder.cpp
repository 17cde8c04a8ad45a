#include <cmath>

#include "contact/tools/tool_list.h"

namespace palpate {
namespace {
namespace flat_cylinder {

constexpr Parameter parameters[] = {
    // 0.3: default_rounding_per_radius
    {"edge_radius", "rim", Parameter::Type::Number, "m", "0", atLeast(0),
     "Rounding of the rims; 0: 0.3 of the radius. Skin catches on rims that are sharper than its edges are long (some "
     "quarter of the radius) where the tool is drawn aside: the error to expect says by how much."},
};

/// Distance to the cylinder of radius R - e and ends drawn in by e, less e.
ToolDistance distance(const ToolProfile& p, const Vec3& x) {
  const double e = p.rounding;
  const double r = std::sqrt(x.x() * x.x() + x.y() * x.y());
  const double half = 0.5 * p.length;
  // In the plane through the axis: how far beyond the core's wall (a) and end (b).
  const double a = r - p.corner[1].r;
  const double b = std::abs(x.z() - half) - (half - e);
  const Vec3 outward = r > 0.0 ? Vec3(x.x() / r, x.y() / r, 0.0) : Vec3::UnitX();
  const Vec3 endward = x.z() < half ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitZ());
  if (a > 0.0 && b > 0.0) {
    const double length = std::sqrt(a * a + b * b);
    return {length - e, (a * outward + b * endward) / length};
  }
  return b >= a ? ToolDistance{b - e, endward} : ToolDistance{a - e, outward};
}

ToolProfile profile(const ToolShape& tool) {
  const double e = roundingOf(tool, tool.parameter[0]), wall = tool.radius - e, end = tool.length - e;
  ToolProfile p = makeToolProfile(tool.radius, tool.length, e, {{0.0, e}, {wall, e}, {wall, end}, {0.0, end}});
  p.closed_form = distance;
  return p;
}

std::optional<ToolFault> fault(const ToolShape& tool) {
  if (tool.parameter[0] > tool.radius) {
    return ToolFault{"edge_radius", "the rim's rounding exceeds the tool's radius",
                     "give at most the radius; a capsule has a round tip"};
  }
  if (tool.length < 2.0 * tool.parameter[0]) {
    return ToolFault{"length", "a cylinder shorter than its two rounded rims", "lengthen it"};
  }
  return std::nullopt;
}

}  // namespace flat_cylinder
}  // namespace

constinit const ToolType tool_types::FlatCylinder{
    "cylinder",           "flat cylinder", "a flat-ended cylinder", flat_cylinder::parameters, flat_cylinder::profile,
    flat_cylinder::fault,
};

}  // namespace palpate

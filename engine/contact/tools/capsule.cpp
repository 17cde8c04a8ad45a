#include <algorithm>

#include "contact/tools/tool_list.h"

namespace palpate {
namespace {
namespace capsule {

/// The core is the piece of the axis between the centres of the caps.
ToolProfile profile(const ToolShape& tool) {
  const double R = tool.radius, length = std::max(2.0 * R, tool.length);
  return makeToolProfile(R, length, R, {{0.0, R}, {0.0, std::max(R, tool.length - R)}});
}

std::optional<ToolFault> fault(const ToolShape& tool) {
  if (tool.length >= 2.0 * tool.radius) return std::nullopt;
  return ToolFault{"length", "a capsule shorter than two radii", "lengthen it, or make it a sphere"};
}

}  // namespace capsule
}  // namespace

constinit const ToolType tool_types::Capsule{
    "capsule", "capsule", "a cylinder with round ends, at least two radii long", {}, capsule::profile, capsule::fault,
};

}  // namespace palpate

#include "contact/tools/tool_list.h"

namespace palpate {
namespace {
namespace sphere {

/// The core is the centre.
ToolProfile profile(const ToolShape& tool) {
  return makeToolProfile(tool.radius, 2.0 * tool.radius, tool.radius, {{0.0, tool.radius}});
}

std::optional<ToolFault> fault(const ToolShape&) { return std::nullopt; }

}  // namespace sphere
}  // namespace

constinit const ToolType tool_types::Sphere{
    "sphere", "sphere", "a ball", {}, sphere::profile, sphere::fault, 0.32, 5.5,
};

}  // namespace palpate

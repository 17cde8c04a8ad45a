#include "contact/tool.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "contact/tools/tool_list.h"

namespace palpate {
namespace {

static_assert(ToolKind{} == ToolKind::Sphere);
static_assert(std::is_trivially_copyable_v<ToolShape> && std::is_trivially_copyable_v<ToolProfile>);

#define PALPATE_ADDRESS(name) &tool_types::name,
constexpr const ToolType* types[] = {PALPATE_TOOLS(PALPATE_ADDRESS)};
#undef PALPATE_ADDRESS

}  // namespace

const ToolType& toolType(ToolKind kind) { return *types[static_cast<int>(kind)]; }

std::span<const ToolType* const> toolTypes() { return types; }

ToolShape ToolShape::of(ToolKind kind, double radius, double length) {
  ToolShape tool{kind, radius, length, {}};
  std::size_t k = 0;
  for (const Parameter& parameter : toolType(kind).parameters) tool.parameter.at(k++) = parameter.fallbackValue();
  return tool;
}

ToolProfile toolProfile(const ToolShape& tool) { return toolType(tool.kind).profile(tool); }

double roundingOf(const ToolShape& tool, double asked) {
  const double e = asked > 0.0 ? asked : default_rounding_per_radius * tool.radius;
  return std::min({e, tool.radius, 0.5 * tool.length});
}

ToolDistance toolDistance(const ToolShape& tool, const Vec3& local) { return toolDistance(toolProfile(tool), local); }

double tipProfile(const ToolShape& tool, double r) { return tipProfile(toolProfile(tool), r); }

double touchRadius(const ToolShape& tool) {
  const ToolProfile profile = toolProfile(tool);
  const bool flat = profile.corner_count > 1 && profile.side_normal[0].z < -0.999;  // a cone's: -sin 80 degrees at most
  return flat ? tool.radius : std::sqrt(profile.rounding * tool.radius);
}

double largestTravel(const ToolShape& tool, const Pose& from, const Pose& to) {
  const double end = std::max(toolProfile(tool).length, 2.0 * tool.radius);
  const double angle = from.orientation.angularDistance(to.orientation);
  return (to.position - from.position).norm() + angle * std::hypot(end, tool.radius);
}

}  // namespace palpate

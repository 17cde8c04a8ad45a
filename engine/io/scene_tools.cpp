#include "io/scene_tools.h"

#include <algorithm>
#include <optional>

#include "base/printable_text.h"
#include "contact/tool_set.h"
#include "io/scene_keys.h"
#include "io/scene_materials.h"

namespace palpate {
namespace {

/// 1/s, top speed of a tool by its radius, where nothing is said: a ball of 0.5 mm that may go 1 m/s takes 32 steps a
/// tick, and all skin of an organ of 5 mm into its contact.
constexpr double quickest_radii = 400;

/// The groups of keys that tools may have.
std::vector<std::string> toolGroups() {
  std::vector<std::string> groups{"tool"};
  for (const ToolType* type : toolTypes()) groups.push_back(toolKeyGroup(*type));
  return groups;
}

/// The script that a tool follows; "": a hand leads it.
std::string readInput(const TomlTable& table, const std::filesystem::path& folder) {
  const std::string script = "script:";
  std::string input = "hand";
  table.read("input", input);
  if (input == "hand") return "";
  if (!input.starts_with(script))
    throw InputError(table.place("input"), inQuotes(input) + " is no input",
                     "give \"hand\", or \"script:FILE\" with a tool script");
  return existingFile(table, "input", folder / input.substr(script.size()), "tool script");
}

/// @param any  in which the keys of all tools may stand
ToolSpec readTool(const TomlTable& any, const std::filesystem::path& folder) {
  ToolSpec spec;
  ToolShape& tool = spec.shape;
  tool.kind = static_cast<ToolKind>(any.readChoice("shape", 0));
  const ToolType& type = toolType(tool.kind);
  for (const ToolType* other : toolTypes())
    any.forbidForeign(other->parameters, type.parameters, std::string("to a ") + type.title);

  const TomlTable table = any.within({"tool", toolKeyGroup(type)});
  table.read("radius", tool.radius);
  table.read("length", tool.length);
  tool = ToolShape::of(tool.kind, tool.radius, tool.length);
  for (std::size_t k = 0; k < type.parameters.size(); ++k) table.read(type.parameters[k].name, tool.parameter[k]);
  table.read("position", spec.position);
  spec.place = table.place("position");
  table.readDirection("direction", spec.direction);
  spec.max_speed = std::min(spec.max_speed, quickest_radii * tool.radius);
  table.read("max_speed", spec.max_speed);
  table.read("max_force", spec.max_force);
  table.read("friction", spec.friction);
  table.read("opening", spec.opening);
  table.read("grip_force", spec.grip_force);
  if (!spec.jaws()) table.forbid({"grip_force"}, "to a tool without \"opening\", which is no jaws");
  spec.script = readInput(table, folder);
  if (const std::optional<ToolFault> fault = type.fault(tool))
    throw InputError(table.place(fault->key), fault->problem, fault->advice);
  return spec;
}

}  // namespace

void readTools(const TomlTable& top, const std::filesystem::path& folder, Scene& scene) {
  std::vector<ToolSpec> specs;
  if (top.isList("tool")) {
    for (const TomlTable& entry : top.tables("tool", toolGroups())) {
      if (specs.size() == std::size_t{max_tools})
        throw InputError(entry.place(), "more than " + std::to_string(max_tools) + " tools", "leave the others out");
      specs.push_back(readTool(entry, folder));
    }
  } else {
    specs.push_back(readTool(top.table("tool", toolGroups()), folder));
  }
  if (!specs.empty()) scene.tools = std::move(specs);
}

void readDevice(const TomlTable& table, DeviceSettings& device) {
  device = DeviceSettings::of(table.readChoice("class", 0));
  table.read("stiffness", device.stiffness);
  table.read("damping", device.damping);
  table.read("max_force", device.max_force);
  table.read("rise_time", device.rise_time);
  table.read("scale", device.scale);
  table.read("own_damping", device.own_damping);
  table.read("lever", device.lever);
  device.locked = table.readChoice("orientation", 0) == 1;
}

}  // namespace palpate

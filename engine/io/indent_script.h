#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/script_trajectory.h"
#include "io/tool_script.h"
#include "model/model.h"

namespace palpate {

/// What the tool does off-screen when no script is given: as the scene's own script for it says, or from its start
/// along its axis to the skin, smoothly on into the tissue, and there it stays.
/// The depth is 1.2 radii of the tool, but at most a quarter of the organ's length along
/// the axis, so that each scene shows a plain indentation that it survives.
ToolScript indentScript(const Model& model);

/// The script that --tool names (findToolScript); none where it names none. Throws InputError.
/// @param tool_radius  m, of the scene
std::optional<ToolScript> namedScript(const std::string& name, double tool_radius);

/// The script's poses tick by tick, for a tool of a model and its rate.
ScriptTrajectory trajectoryOf(const ToolScript& script, const Model& model, int tool = 0);

/// The ways of the tools beside the first whose scene has a script for them. Throws InputError. For set-up.
void addToolPaths(Model& model);

/// All of them at once, and how far jaws are open. Throws InputError where they would be more than a million.
std::vector<ToolPosture> scriptWay(const ToolScript& script, const Model& model, int tool = 0);

}  // namespace palpate

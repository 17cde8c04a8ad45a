#pragma once

#include <span>
#include <string>

#include "contact/tool.h"
#include "io/key_spec.h"

namespace palpate {

/// Every key a scene file may have, in the order of the reference.
std::span<const KeySpec> sceneKeys();

/// The group of the keys in [tool] that only this tool has: "tool (cylinder)".
std::string toolKeyGroup(const ToolType& tool);

/// The reference of all scene keys as Markdown: what assets/scenes/README.md holds between its marks.
std::string sceneReference();

}  // namespace palpate

#pragma once

#include <filesystem>

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// What [skull] and the entries of [[rigid]] say, [skull] first. Throws InputError with file:line:column.
/// @param top         the scene's top level
/// @param boundaries  whose names are taken
std::vector<RigidSpec> readRigidBodies(const TomlTable& top, const std::filesystem::path& folder,
                                       const std::vector<BoundarySpec>& boundaries);

}  // namespace palpate

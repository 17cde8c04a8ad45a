#pragma once

#include <filesystem>

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// Reads [tool], or up to max_tools of [[tool]]. Throws InputError where one can't be used.
/// @param folder  the scene's, from which scripts are looked for
void readTools(const TomlTable& top, const std::filesystem::path& folder, Scene& scene);

/// Reads [device].
void readDevice(const TomlTable& table, DeviceSettings& device);

}  // namespace palpate

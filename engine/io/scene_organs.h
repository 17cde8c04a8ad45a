#pragma once

#include <filesystem>

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// [organ], or several as [[organ]]. Throws InputError, as all three, with file:line:column.
/// @param folder  from which the paths of files start
void readOrgans(const TomlTable& top, const std::filesystem::path& folder, Scene& scene);

/// Which organ the table's "organ" names (Scene::organs); -1: none.
int organNamed(const TomlTable& table, const Scene& scene);

/// Each organ has a material that is everywhere in it.
void checkMaterials(const Scene& scene);

}  // namespace palpate

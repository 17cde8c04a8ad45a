#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// A file that a key names. Throws InputError where it is not there.
/// @param path  the scene's folder joined with what the key says, which replaces it where it is absolute
std::string existingFile(const TomlTable& table, const std::string& key, const std::filesystem::path& path,
                         const std::string& what);

/// Reads a [[material]]. Throws InputError where its law, its place or its images can't be used.
/// @param folder  the scene's, from which files are looked for
/// @param before  the materials that the scene has so far
void readMaterial(const TomlTable& table, const std::filesystem::path& folder, const std::vector<MaterialSpec>& before,
                  MaterialSpec& material);

}  // namespace palpate

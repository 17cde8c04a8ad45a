#pragma once

#include <string>

namespace palpate {

/// A folder of assets/, with the program's own scenes or tool scripts: "scenes", "tools".
std::string assetFolder(const std::string& name);

/// The scene file that `scene` means: itself where such a file exists, otherwise NAME.toml in `folder`.
/// Throws InputError naming the scenes of the folder, and the nearest, where there is neither.
std::string findScene(const std::string& scene, const std::string& folder = assetFolder("scenes"));

/// Likewise the tool script that --tool means.
std::string findToolScript(const std::string& script, const std::string& folder = assetFolder("tools"));

}  // namespace palpate

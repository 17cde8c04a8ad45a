#pragma once

#include <span>
#include <string>

#include "scene/scene.h"

namespace palpate {

/// Reads a scene from a TOML file; assets/scenes/README.md lists the keys, made from io/scene_keys.h.
///
/// Everything is checked that needs no geometry. Throws InputError ("file:line:column: what is wrong; what
/// would be right") for a missing file, invalid TOML, an unknown key (naming the nearest known one), a
/// wrong type, a value out of range or contradicting another, a missing key, a missing surface or probes file.
///
/// In the result `surface_file` and `solve.probes_file` are the scene's folder joined with the path in the scene,
/// directions are unit vectors, angles of boundaries rad, names of boundaries unique, and `places` has each key that
/// the file sets: "dynamics.time_step", "material[0].young",
/// "fixed[1]" (lists count from 0). Boundaries are in the file's order, all fixed ones first.
Scene readScene(const std::string& path);

/// A key that gets another value than the file's: "dynamics.damping", "material[0].young" (lists count from 0; the
/// entry must be there).
struct SceneChange {
  std::string key;
  std::string value;  // as TOML writes it: `0.01`, `"int16"`, `[0, 0, 1]`
};

/// "material[0].young = 4000" as a change. Throws InputError where there is no key or no value.
SceneChange changeFrom(const std::string& assignment);

/// The same with changes, which are checked as if they stood in the file.
Scene readScene(const std::string& path, std::span<const SceneChange> changes);

/// A scene that is no file.
struct SceneText {
  std::string text;    // TOML
  std::string folder;  // that its paths start from
  std::string name;    // what errors call it
};

/// The same from a text.
Scene readScene(const SceneText& scene, std::span<const SceneChange> changes = {});

/// Runs the scene at another rate than the file's. A preparation with added mass depends on it.
void overrideRate(Scene& scene, double rate_hz);

}  // namespace palpate

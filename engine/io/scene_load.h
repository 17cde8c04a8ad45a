#pragma once

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// An entry of [[load]]. Throws InputError with file:line:column.
/// @param scene  with the boundaries and loads read so far, whose names are taken
LoadSpec readLoad(const TomlTable& table, const Scene& scene);

}  // namespace palpate

#pragma once

#include <string>
#include <vector>

#include "io/toml_table.h"
#include "simulation/scene.h"

namespace palpate {

/// The region that a table's keys choose.
Region readRegion(const TomlTable& table);

/// An entry of [[fixed]]. Throws InputError, as all three, with file:line:column.
/// @param before  the boundaries read so far: they number the usual name ("fixed 2"), and no two
///                may have the same name
BoundarySpec readFixed(const TomlTable& table, const std::vector<BoundarySpec>& before);

/// An entry of [[prescribed]]; those come after the fixed ones.
/// @param folder  from which the paths of files start
BoundarySpec readPrescribed(const TomlTable& table, const std::string& folder, const std::vector<BoundarySpec>& before);

/// The motion that the keys of a [[prescribed]] region, or of a [[rigid]] body, describe.
BoundarySpec readMotion(const TomlTable& table);

}  // namespace palpate

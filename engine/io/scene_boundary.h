#pragma once

#include <string>
#include <vector>

#include "io/toml_table.h"
#include "scene/scene.h"

namespace palpate {

/// The region that a table's keys choose.
Region readRegion(const TomlTable& table);

/// How a motion or load goes over time: the keys duration, curve and curve_table.
/// @param what  "a motion", for messages
void readCourse(const TomlTable& table, const std::string& what, double& duration, LoadCurve& curve);

/// Throws where a name is not fit to head a column of CSV results, or is that of one of the others.
template <class Spec>
void checkResultName(const TomlTable& table, const std::string& name, const std::vector<Spec>& others);

/// An entry of [[fixed]]. Throws InputError, as all here, with file:line:column.
/// @param before  the boundaries read so far: they number the usual name ("fixed 2"), and no two
///                may have the same name
BoundarySpec readFixed(const TomlTable& table, const std::vector<BoundarySpec>& before);

/// An entry of [[prescribed]]; those come after the fixed ones.
/// @param folder  from which the paths of files start
BoundarySpec readPrescribed(const TomlTable& table, const std::string& folder, const std::vector<BoundarySpec>& before);

/// The motion that the keys of a [[prescribed]] region, or of a [[rigid]] body, describe.
BoundarySpec readMotion(const TomlTable& table);

}  // namespace palpate

#pragma once

#include "mtled/atlas/atlas_cells.h"

namespace palpate::tools {

/// README.md, results.json and atlas.png in a folder, which is made where it is missing.
/// @param command  that repeats it
void writeAtlasPage(const std::string& folder, const std::string& command, const Atlas& atlas,
                    const std::vector<AtlasAxis>& axes);

}  // namespace palpate::tools

#pragma once

#include "mtled/atlas/atlas_cells.h"

namespace palpate::tools {

/// The map: a row of coloured squares for each axis that the atlas has cells of, with a letter for who can't tell
/// the colours. Throws std::runtime_error where there is no off-screen drawing or the file can't be written.
void writeAtlasFigure(const std::string& png, const Atlas& atlas, const std::vector<AtlasAxis>& axes);

/// README.md, results.json and atlas.png in a folder, which is made where it is missing.
/// @param command  that repeats it
void writeAtlasPage(const std::string& folder, const std::string& command, const Atlas& atlas,
                    const std::vector<AtlasAxis>& axes);

}  // namespace palpate::tools

#pragma once

#include <string>
#include <vector>

#include "mtled/atlas/atlas_cells.h"

namespace palpate::tools {

struct AtlasOptions {
  std::vector<std::string> cells;  // names of cells or axes; empty: all
  bool quick = false;              // about a third of them
  std::string out = "out/atlas";   // folder of atlas.json, atlas.csv, atlas.png
  std::string json;                // the results once more; empty: not
  std::string report;              // folder of a page with the map; empty: none
  bool resume = false;             // keep the cells that the folder's atlas.json has already
};

/// Drives small bodies to the ends of what the program can do and says for each whether its numbers are true, doubted
/// or refused. Leaves what is done in the folder after each cell.
/// @return 0 done, 1 a cell was silently wrong, or interrupted (what is done is kept)
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int atlasCommand(const AtlasOptions& options);

/// The same over other axes and cells: for tests.
int atlasCommand(const AtlasOptions& options, const std::vector<AtlasAxis>& axes, const std::vector<AtlasCell>& cells);

}  // namespace palpate::tools

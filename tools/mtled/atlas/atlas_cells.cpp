#include "mtled/atlas/atlas_cells.h"

namespace palpate::tools {
namespace {

struct Map {
  std::vector<AtlasAxis> axes;
  std::vector<AtlasCell> cells;
  Map() {
    for (const auto add : {addSolidCells, addToolCells, addSceneCells, addCloudCells, addNumericCells})
      add(axes, cells);
  }
};

const Map& map() {
  static const Map map;
  return map;
}

}  // namespace

std::string AtlasCell::name() const {
  std::string name = axis + "/" + value;
  for (char& c : name)
    if (c == ' ') c = '_';
  return name;
}

const std::vector<AtlasAxis>& atlasAxes() { return map().axes; }
const std::vector<AtlasCell>& atlasCells() { return map().cells; }

}  // namespace palpate::tools

#pragma once

#include <vector>

#include "app/render/picture.h"
#include "mtled/atlas/atlas_cells.h"

namespace palpate::app {
class Canvas;
}

namespace palpate::tools {

/// The map that Pictures::write draws of an atlas.
app::Picture drawAtlasMap(app::Canvas& canvas, const Atlas& atlas, const std::vector<AtlasAxis>& axes);

}  // namespace palpate::tools

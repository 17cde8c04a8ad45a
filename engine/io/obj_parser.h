#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses an OBJ file's text. Vertices are not joined. `file` is for messages.
SurfaceFile parseObj(const std::string& text, const std::string& file);

}  // namespace palpate

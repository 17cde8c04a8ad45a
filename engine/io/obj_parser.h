#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses an OBJ file's text. Vertices are not joined. `file` is for messages.
/// Tolerant: what can be read is taken; faces may name vertices that are not there, vertices may be NaN.
SurfaceFile parseObj(const std::string& text, const std::string& file, SurfaceReading reading = SurfaceReading::Strict);

}  // namespace palpate

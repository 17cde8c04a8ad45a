#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses an STL file's bytes, ASCII or binary; the size tells which, since binary files, too, may
/// begin with "solid". Vertices are not joined: each face has its own three. `file` is for messages.
/// Tolerant: what can be read is taken; faces may name vertices that are not there, vertices may be NaN.
SurfaceFile parseStl(const std::string& bytes, const std::string& file,
                     SurfaceReading reading = SurfaceReading::Strict);

}  // namespace palpate

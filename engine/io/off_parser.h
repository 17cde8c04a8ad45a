#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses a text OFF file (also COFF, NOFF and the like: colours and normals behind the coordinates are passed over).
/// Vertices are not joined. `file` is for messages. Tolerant: what can be read is taken; faces may name vertices that
/// are not there.
SurfaceFile parseOff(const std::string& bytes, const std::string& file,
                     SurfaceReading reading = SurfaceReading::Strict);

}  // namespace palpate

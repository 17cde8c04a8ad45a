#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses a PLY file's bytes, text or binary of either byte order: the elements "vertex" (x, y, z) and "face" (the list
/// "vertex_indices" or "vertex_index"); others are passed over. Vertices are not joined.
/// `file` is for messages. Tolerant: what can be read is taken; faces may name vertices that are not there.
SurfaceFile parsePly(const std::string& bytes, const std::string& file,
                     SurfaceReading reading = SurfaceReading::Strict);

}  // namespace palpate

#pragma once

#include <string>

#include "io/surface_file.h"

namespace palpate {

/// Parses a legacy VTK file of a POLYDATA set, text or binary: its POINTS and POLYGONS, in the layout of versions up
/// to 4 or of 5 (OFFSETS and CONNECTIVITY). Vertices are not joined. `file` is for messages. Tolerant: what can be
/// read is taken; faces may name vertices that are not there.
SurfaceFile parseVtk(const std::string& bytes, const std::string& file,
                     SurfaceReading reading = SurfaceReading::Strict);

}  // namespace palpate

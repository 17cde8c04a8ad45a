#pragma once

#include <string>

#include "base/input_error.h"
#include "discretization/surface/surface_check.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// A surface as a file has it, and where each part of it stands there.
struct SurfaceFile {
  TriangleSurface surface;  // m; coincident vertices joined, unused ones dropped (weldVertices)
  SurfaceSource source;
};

/// Reads an OBJ or STL file (ASCII or binary, told apart by content). Coordinates are multiplied by `scale`.
///
/// OBJ: `v` and `f` count; textures, normals, groups and materials are skipped, polygons are cut into
/// fans, indices may be negative (relative). STL: the stated normals are ignored, the vertex order counts.
///
/// Throws InputError naming file and line (for binary STL the face) where the file is missing, empty,
/// cut short or damaged. Does not ask whether the surface is closed: readClosedSurface does.
/// @param asked_from  where another file names this one; place of the error when the file is missing
SurfaceFile readSurface(const std::string& path, double scale = 1.0, const SourceLocation& asked_from = {});

/// The same from the file's bytes. @param path  its ending tells the format; for messages, too
SurfaceFile surfaceFrom(const std::string& bytes, const std::string& path, double scale = 1.0);

/// readSurface, then checkSurface: the surface bounds a solid.
TriangleSurface readClosedSurface(const std::string& path, double scale = 1.0, const SourceLocation& asked_from = {});

/// Writes an OBJ file that reads back to the same bits. Throws std::runtime_error where that fails.
void writeObj(const TriangleSurface& surface, const std::string& path);

}  // namespace palpate

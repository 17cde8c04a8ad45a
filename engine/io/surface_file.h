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
  int concave_polygons = 0;  // that were cut into triangles
  int unused_vertices = 0;   // that no face has, left out
  int unreadable_faces = 0;  // left out (SurfaceReading::Tolerant): cut off, or with a vertex that is not there
  std::string unreadable;    // the first line that can't be read, and why; "": none is known
};

/// Whether a damaged file is refused, or what can be read of it is taken and the rest counted.
enum class SurfaceReading { Strict, Tolerant };

/// The endings of the formats that can be read, as a message lists them: ".obj, .stl, ..."
std::string surfaceFormats();

/// Reads an OBJ, STL, PLY, OFF or legacy VTK file, text or binary. Coordinates are multiplied by `scale`.
///
/// Polygons are cut into triangles. OBJ: `v` and `f` count; textures, normals, groups and materials are skipped,
/// indices may be negative (relative). STL: the stated normals are ignored, the vertex order counts. PLY: the elements
/// "vertex" and "face". VTK: the points and polygons of a POLYDATA set.
///
/// Throws InputError naming file and line (for binary files the face) where the file is missing, empty,
/// cut short or damaged. Does not ask whether the surface is closed: readClosedSurface does.
/// @param asked_from  where another file names this one; place of the error when the file is missing
SurfaceFile readSurface(const std::string& path, double scale = 1.0, const SourceLocation& asked_from = {},
                        SurfaceReading reading = SurfaceReading::Strict);

/// The same from the file's bytes. @param path  its ending tells the format; for messages, too
SurfaceFile surfaceFrom(const std::string& bytes, const std::string& path, double scale = 1.0,
                        SurfaceReading reading = SurfaceReading::Strict);

/// readSurface, then checkSurface: the surface bounds a solid. The refusal of one that does not says how to repair it.
TriangleSurface readClosedSurface(const std::string& path, double scale = 1.0, const SourceLocation& asked_from = {});

/// Writes an OBJ file that reads back to the same bits. Throws std::runtime_error where that fails.
void writeObj(const TriangleSurface& surface, const std::string& path);

}  // namespace palpate

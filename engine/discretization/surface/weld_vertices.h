#pragma once

#include "discretization/surface/surface_check.h"

namespace palpate {

/// Joins vertices closer than a millionth of the bounding box's diagonal and drops those that no face uses. STL files,
/// which repeat each vertex in each face, need it; so do OBJ files that were split along texture seams. Keeps `source`
/// in step. A face that collapses by it stays, for checkSurface to refuse. Does nothing where a coordinate or the
/// diagonal is not finite. Costs ~ vertex_count. Returns the number of vertices removed.
int weldVertices(TriangleSurface& surface, SurfaceSource& source);

/// Keeps the faces for which stays(triangle), and their lines. Returns how many went.
template <class Stays>
int keepFaces(TriangleSurface& surface, SurfaceSource& source, Stays stays) {
  std::size_t kept = 0;
  const std::size_t count = surface.triangles.size();
  for (std::size_t t = 0; t < count; ++t) {
    if (!stays(static_cast<int>(t))) continue;
    surface.triangles[kept] = surface.triangles[t];
    if (!source.triangle_line.empty()) source.triangle_line[kept] = source.triangle_line[t];
    ++kept;
  }
  surface.triangles.resize(kept);
  if (!source.triangle_line.empty()) source.triangle_line.resize(kept);
  return static_cast<int>(count - kept);
}

/// Vertices that no face uses go.
void dropUnusedVertices(TriangleSurface& surface, SurfaceSource& source);

}  // namespace palpate

#pragma once

#include "discretization/surface/surface_check.h"

namespace palpate {

/// Joins vertices closer than a millionth of the bounding box's diagonal and drops those that no face uses. STL files,
/// which repeat each vertex in each face, need it; so do OBJ files that were split along texture seams. Keeps `source`
/// in step. A face that collapses by it stays, for checkSurface to refuse. Does nothing where a coordinate or the
/// diagonal is not finite. Costs ~ vertex_count. Returns the number of vertices removed.
int weldVertices(TriangleSurface& surface, SurfaceSource& source);

/// Vertices that no face uses go.
void dropUnusedVertices(TriangleSurface& surface, SurfaceSource& source);

}  // namespace palpate

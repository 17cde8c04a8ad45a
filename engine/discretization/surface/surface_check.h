#pragma once

#include <string>
#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Where a surface came from, so that complaints can name lines of its file.
struct SurfaceSource {
  std::string file;                // empty: made by a program
  std::vector<int> vertex_line;    // (vertex_count) or empty; 1-based, 0 not known
  std::vector<int> triangle_line;  // (triangle_count) or empty
};

/// Refuses a surface that does not bound a solid, naming the place and what to do (InputError):
///
/// - no faces, non-finite coordinates, vertex indices out of range
/// - faces with zero area or a repeated vertex
/// - open edges (holes), edges shared by more than two faces
/// - faces turned against their neighbours, surfaces that are inside out
/// - faces that pierce one another
///
/// Vertices that no face uses are allowed (an OBJ may have them). Several separate closed parts
/// are allowed where they do not cut one another; a part inside another must be a cavity, its
/// faces pointing into the hollow, and two parts may touch in vertices only.
void checkSurface(const TriangleSurface& surface, const SurfaceSource& source = {});

/// Joins vertices closer than `relative_tolerance` times the bounding box's diagonal and drops those that
/// no face uses. STL files, which repeat each vertex in each face, need it; so do OBJ files that were
/// split along texture seams. Keeps `source` in step. A face that collapses by it stays, for checkSurface to
/// refuse. Does nothing where a coordinate is not finite. Returns the number of vertices removed.
int weldVertices(TriangleSurface& surface, SurfaceSource& source, double relative_tolerance = 1e-6);

}  // namespace palpate

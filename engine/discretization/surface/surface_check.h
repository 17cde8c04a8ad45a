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

/// Whether two faces that share no edge go through one another.
bool facesPierce(const TriangleSurface& surface, int s, int t);

/// The faces that pierce another one, ascending; the search ends with the pair that makes them `most` or more.
std::vector<int> piercingFaces(const TriangleSurface& surface, int most);

}  // namespace palpate

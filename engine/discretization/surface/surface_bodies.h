#pragma once

#include <vector>

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// The bodies that a closed surface bounds: each an outer shell with the cavities in it.
struct SurfaceBodies {
  int count = 0;
  std::vector<int> of_face;  // (triangle_count) 0 .. count-1, in the order of the shells' first faces

  /// By vertices; of one that several bodies share, the last. Vertices without a face: -1. (vertex_count)
  std::vector<int> ofVertices(const TriangleSurface& surface) const;
};

/// @param surface  closed; faces point outward, those of cavities into the hollow (surface_check.h)
SurfaceBodies bodiesOf(const TriangleSurface& surface);

/// Each body's surface on its own, with the vertices it uses; one body's as it is. (bodies.count)
std::vector<TriangleSurface> separated(const TriangleSurface& surface, const SurfaceBodies& bodies);

/// Adds vertices and faces of a further body; TriangleSurface::organ stays as it is.
void addSurface(const TriangleSurface& more, TriangleSurface& all);

}  // namespace palpate

#pragma once

#include "discretization/surface/triangle_surface.h"
#include "organs/organ.h"

namespace palpate::organs {

/// The zero level of `organ.field` inside its box, by marching tetrahedra on a grid of
/// spacing `cell` (m): closed and manifold as long as the surface stays inside the box,
/// outward normals, uneven triangles (remesh.h makes them even).
/// @throws InputError if the surface reaches the box.
TriangleSurface isosurface(const Organ& organ, double cell);

}  // namespace palpate::organs

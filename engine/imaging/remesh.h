#pragma once

#include "imaging/isosurface.h"

namespace palpate {

/// Even, near-equilateral triangles of about `edge_length` (m) on the zero level of `field`,
/// starting from any closed manifold triangulation of it. Topology and orientation are kept.
///
/// Isotropic remeshing (Botsch and Kobbelt, "A remeshing approach to multiresolution
/// modeling", SGP 2004): split what is longer than 4/3 of the target, collapse what is
/// shorter than 4/5, flip towards six neighbours per vertex, relax in the tangent plane,
/// and put each vertex back on the surface - here on the field itself, so nothing drifts.
TriangleSurface remesh(const TriangleSurface& surface, const Field& field, double edge_length);

}  // namespace palpate

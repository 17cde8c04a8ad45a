#pragma once

#include <array>

#include "base/types.h"

namespace palpate {

/// The corners of a tetrahedron, m.
using Corners = std::array<Vec3, 4>;

/// Divides a tetrahedron into 2, 4 or 8 of equal volume (paper section 3, before 3.1); orientation may turn.
///
///   2: at the midpoint of the longest edge (of equal ones the first)
///   4: at the midpoints of the edges of one face, each quarter joined to the opposite corner. The face changes
///      with the depth: it is the one opposite corner 3, 2, 1, 0, 3, .. If it were always the same face, the
///      cells would stay as long as their parent towards the opposite corner.
///   8: at all edges' midpoints: four corners, and the octahedron between them in four around its shortest
///      diagonal
///
/// @param division  2, 4 or 8
/// @param depth     divisions that led to this cell
/// @param children  receives `division` tetrahedra
/// Test: discretization/cells/adaptive_quadrature_test.cpp
void divideCell(const Corners& corners, int division, int depth, std::array<Corners, 8>& children);

}  // namespace palpate

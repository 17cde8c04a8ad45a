#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Delaunay tetrahedra of points, positively oriented, sorted by their vertices (qhull's order, and
/// with it the result's, is a function of the points alone). Cospherical points are cut into
/// tetrahedra that may not match across a shared face, but fill the hull; tetrahedra without volume
/// (four points on a flat face of the hull) are left out.
///
/// @param X  positions, m   (point_count); at least 4, not all in one plane
/// Throws std::runtime_error with qhull's message where qhull fails (e.g. all points in one plane).
/// Test: discretization/cells/background_cells_test.cpp (empty spheres, volume of the hull)
std::vector<std::array<int, 4>> delaunay(const std::vector<Vec3>& X);

/// Signed volume of a tetrahedron, (b - a) x (c - a) . (d - a) / 6, m^3. Positive is the cells' orientation.
double tetrahedronVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

}  // namespace palpate

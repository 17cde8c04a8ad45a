#pragma once

#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Closed triangle surfaces of simple solids, outward, of near-equilateral triangles with edges of
/// about `edge`, m. Sharp edges of the solid are edges of triangles. The volume is the solid's, to rounding: vertices
/// of round faces lie outside them by as much as faces lie inside, about edge^2 / (8 radius) between them.
/// Deterministic. Throws std::invalid_argument where a length is not finite and positive, or
/// where more than about 4 million faces would be needed.

/// Box of edge lengths `size`, m, base centred at the origin, z from 0 to size.z.
TriangleSurface boxSurface(const Vec3& size, double edge);

/// Cylinder about z, m, base centred at the origin, z from 0 to height.
TriangleSurface cylinderSurface(double radius, double height, double edge);

/// Ellipsoid of the given semi-axes, m, centred at the origin.
TriangleSurface ellipsoidSurface(const Vec3& semi_axes, double edge);

/// The part z >= 0 of an ellipsoid, closed by a flat base at z = 0.
TriangleSurface halfEllipsoidSurface(const Vec3& semi_axes, double edge);

}  // namespace palpate

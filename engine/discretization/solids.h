#pragma once

#include "discretization/triangle_surface.h"

namespace palpate {

/// Closed triangle surfaces of simple solids, outward, with near-equilateral triangles whose edges are
/// about `edge` long, m. Sharp edges of the solid are edges of triangles. Throws std::invalid_argument
/// for sizes or edges that are not positive and finite.

/// Box of edge lengths `size`, base centred at the origin, z from 0 to size.z.
TriangleSurface boxSurface(const Vec3& size, double edge);

/// Cylinder about z, base centred at the origin, z from 0 to height. Its vertices lie on the cylinder, so
/// its volume falls short by about (edge / radius)^2 / 6.
TriangleSurface cylinderSurface(double radius, double height, double edge);

/// Ellipsoid centred at the origin.
TriangleSurface ellipsoidSurface(const Vec3& semi_axes, double edge);

/// The part z >= 0 of an ellipsoid, closed by a flat base at z = 0.
TriangleSurface halfEllipsoidSurface(const Vec3& semi_axes, double edge);

}  // namespace palpate

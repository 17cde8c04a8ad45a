#pragma once

#include <vector>

#include "base/types.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate {

/// Half the cross product of two edges of face t: its normal times its area, m^2.
Vec3 areaVector(const TriangleSurface& surface, int t);

/// Sum of the faces' areas, m^2.
double surfaceArea(const TriangleSurface& surface);

/// Volume enclosed by a closed surface, m^3; negative where its normals point inward.
/// Divergence theorem about the bounding box's centre, so that a surface far from the origin loses no digits.
double signedVolume(const TriangleSurface& surface);

/// m, of the ball that is as round on the whole: area over the integral of the mean curvature, |A / (1/2 dA/dn)|
/// (Steiner). Edges count by their length and angle, bumps and dents against each other. Infinite for a flat surface.
double meanRadius(const TriangleSurface& surface);

/// Smallest axis-aligned box around all vertices, m; empty for a surface without vertices.
inline Box3 boundingBox(const TriangleSurface& surface) { return boxOf(surface.vertices); }
/// The same around a face.
Box3 faceBox(const TriangleSurface& surface, int t);

/// Unit normals at the vertices, each the mean of its faces' normals weighted by their angles at the vertex
/// (independent of how a flat face is divided into triangles). Zero at a vertex without faces. (vertex_count)
std::vector<Vec3> vertexNormals(const TriangleSurface& surface);

/// Point of triangle abc that is closest to x, in barycentric coordinates (weights of a, b, c; sum 1).
Vec3 closestBarycentric(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace palpate

#include "discretization/surface/surface_geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {

Vec3 areaVector(const TriangleSurface& surface, int t) {
  const auto& [a, b, c] = surface.triangles[t];
  const Vec3& A = surface.vertices[a];
  return 0.5 * (surface.vertices[b] - A).cross(surface.vertices[c] - A);
}

double surfaceArea(const TriangleSurface& surface) {
  double area = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) area += areaVector(surface, t).norm();
  return area;
}

double signedVolume(const TriangleSurface& surface) {
  if (surface.triangles.empty()) return 0;
  const Vec3 centre = boundingBox(surface).center();
  double volume = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    volume += areaVector(surface, t).dot(surface.vertices[surface.triangles[t][0]] - centre) / 3.0;
  }
  return volume;
}

Box3 faceBox(const TriangleSurface& surface, int t) {
  Box3 box;
  for (const int v : surface.triangles[t]) box.extend(surface.vertices[v]);
  return box;
}

std::vector<Vec3> vertexNormals(const TriangleSurface& surface) {
  std::vector<Vec3> normals(surface.vertices.size(), Vec3::Zero());
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& triangle = surface.triangles[t];
    const Vec3 normal = areaVector(surface, t).stableNormalized();
    for (int k = 0; k < 3; ++k) {
      const Vec3& v = surface.vertices[triangle[k]];
      const Vec3 e = surface.vertices[triangle[(k + 1) % 3]] - v;
      const Vec3 f = surface.vertices[triangle[(k + 2) % 3]] - v;
      normals[triangle[k]] += std::atan2(e.cross(f).norm(), e.dot(f)) * normal;
    }
  }
  for (Vec3& n : normals) n.stableNormalize();
  return normals;
}

double meanRadius(const TriangleSurface& surface) {
  const double area = surfaceArea(surface), out = 1e-4 * std::sqrt(area);
  TriangleSurface larger = surface;
  const std::vector<Vec3> normals = vertexNormals(surface);
  for (std::size_t v = 0; v < normals.size(); ++v) larger.vertices[v] += out * normals[v];
  const double curvature = 0.5 * (surfaceArea(larger) - area) / out;  // m, integrated
  return std::abs(area / curvature);
}

Vec3 closestBarycentric(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  const double twice_area_squared = normal.squaredNorm();
  if (twice_area_squared > 0) {
    // The foot of the perpendicular, if it lies in the triangle.
    const double v = (x - a).cross(ac).dot(normal) / twice_area_squared;
    const double w = ab.cross(x - a).dot(normal) / twice_area_squared;
    if (v >= 0 && w >= 0 && v + w <= 1) return {1 - v - w, v, w};
  }
  // Otherwise the closest point lies on an edge (also for a degenerate triangle).
  const Vec3* corner[3] = {&a, &b, &c};
  Vec3 best = Vec3::UnitX();
  double best_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const Vec3 edge = *corner[l] - *corner[k];
    const double length_squared = edge.squaredNorm();
    const double s = length_squared > 0 ? std::clamp((x - *corner[k]).dot(edge) / length_squared, 0.0, 1.0) : 0.0;
    const double distance = (x - *corner[k] - s * edge).squaredNorm();
    if (distance < best_distance) {
      best_distance = distance;
      best.setZero();
      best[k] = 1 - s;
      best[l] = s;
    }
  }
  return best;
}

}  // namespace palpate

#pragma once

#include <cmath>
#include <vector>

#include "discretization/surface/solids.h"
#include "discretization/surface/triangle_surface.h"

namespace palpate::bodies {

/// Concave with flat faces: a 100 mm square less a 60 mm square at one corner, 50 mm high, m.
/// Volume (0.1^2 - 0.06^2) 0.05.
inline TriangleSurface angleBracket() {
  const double x[6] = {0, 0.1, 0.1, 0.04, 0.04, 0}, y[6] = {0, 0, 0.04, 0.04, 0.1, 0.1};
  TriangleSurface surface;
  for (int k = 0; k < 6; ++k) {
    surface.vertices.push_back({x[k], y[k], 0});
    surface.vertices.push_back({x[k], y[k], 0.05});
  }
  for (int k = 0; k < 6; ++k) {
    const int l = (k + 1) % 6;
    surface.triangles.push_back({2 * k, 2 * l, 2 * l + 1});
    surface.triangles.push_back({2 * k, 2 * l + 1, 2 * k + 1});
  }
  for (int k = 1; k < 5; ++k) {  // corner 0 sees all others
    surface.triangles.push_back({1, 2 * k + 1, 2 * k + 3});
    surface.triangles.push_back({2 * k + 2, 2 * k, 0});
  }
  return surface;
}

/// Concave and smooth: 120 mm long, 80 mm thick at the ends, 28 mm at the waist.
inline TriangleSurface dumbbell() {
  TriangleSurface surface = ellipsoidSurface(Vec3(1, 1, 1), 0.06);
  for (Vec3& v : surface.vertices) {
    const double thickness = 0.35 + 0.65 * v.x() * v.x();
    v = Vec3(0.06 * v.x(), 0.04 * thickness * v.y(), 0.04 * thickness * v.z());
  }
  return surface;
}

/// A bent, uneven lens with a thin rim, about the size and shape of a liver.
inline TriangleSurface liverLike() {
  TriangleSurface surface = ellipsoidSurface(Vec3(1, 1, 1), 0.06);
  for (Vec3& v : surface.vertices) {
    const double r = 1 + 0.15 * std::sin(3 * v.x() + 1) * std::cos(2 * v.y()) + 0.1 * std::sin(4 * v.z());
    v = (r * v).cwiseProduct(Vec3(0.1, 0.07, 0.035));
    v.z() -= 3 * v.x() * v.x();
  }
  return surface;
}

/// A body and a node spacing that suits it, m.
struct Body {
  const char* name;
  TriangleSurface surface;
  double h;
};

/// Bodies of flat and curved faces, convex and concave.
inline std::vector<Body> variedBodies() {
  return {
      {"box", boxSurface({0.1, 0.08, 0.05}, 0.02), 0.008},
      {"cylinder", cylinderSurface(0.015, 0.017, 0.0015), 0.003},
      {"ellipsoid", ellipsoidSurface({0.08, 0.05, 0.03}, 0.004), 0.009},
      {"half ellipsoid", halfEllipsoidSurface({0.08, 0.06, 0.05}, 0.004), 0.009},
      {"dumbbell", dumbbell(), 0.007},
      {"angle bracket", angleBracket(), 0.01},
      {"liver-like", liverLike(), 0.01},
  };
}

}  // namespace palpate::bodies

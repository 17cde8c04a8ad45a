#include "contact/skin_points.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "discretization/surface/solids.h"
#include "discretization/surface/surface_bodies.h"
#include "discretization/surface/surface_geometry.h"

using namespace palpate;

TEST_CASE("Points of each body are as far apart as asked, near any other body, and stand for all of its skin",
          "[contact][skin_points]") {
  SkinModel skin;
  TriangleSurface above = boxSurface(Vec3::Constant(0.02), 0.0015);
  for (Vec3& x : above.vertices) x.z() += 0.0201;
  skin.surface = boxSurface(Vec3::Constant(0.02), 0.0015);
  addSurface(above, skin.surface);
  skin.area.assign(skin.surface.vertices.size(), 0);
  for (int t = 0; t < static_cast<int>(skin.surface.triangles.size()); ++t)
    for (const int v : skin.surface.triangles[t]) skin.area[v] += areaVector(skin.surface, t).norm() / 3;
  const std::vector<int> body = bodiesOf(skin.surface).ofVertices(skin.surface);
  // Twice as dense where x > 0.
  const auto apart = [](const Vec3& x) { return x.x() > 0 ? 0.002 : 0.004; };
  const SkinPoints points = skinPoints(skin, body, apart);
  double of_body[2] = {};
  int dense = 0, wide = 0;
  for (std::size_t p = 0; p < points.vertex.size(); ++p) {
    const Vec3& X = skin.surface.vertices[points.vertex[p]];
    of_body[body[points.vertex[p]]] += static_cast<double>(points.area[p]);
    (X.x() > 0 ? dense : wide) += 1;
    for (std::size_t q = 0; q < p; ++q)
      if (body[points.vertex[p]] == body[points.vertex[q]])
        CHECK((X - skin.surface.vertices[points.vertex[q]]).norm() >= apart(X));
  }
  for (const double area : of_body) CHECK(area == Approx(6 * 0.02 * 0.02).epsilon(1e-6));
  CHECK(dense > 2 * wide);
  CHECK(dense < 6 * wide);
}

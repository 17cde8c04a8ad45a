#include <catch2/catch.hpp>

#include "contact/skin.h"

using namespace palpate;

TEST_CASE("Inside is what a closed skin encloses as it is now, straight below its vertices and edges, too",
          "[contact][skin]") {
  SkinModel skin;  // an octahedron, each vertex of which moves with a node of its own
  skin.surface.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  skin.surface.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  skin.begin = {0, 1, 2, 3, 4, 5, 6};
  skin.node = {0, 1, 2, 3, 4, 5};
  skin.N.assign(6, 1.0F);
  AlignedVector<Float4> u(6);
  std::vector<Vec3f> scratch(6);
  const auto inside = [&](double x, double y, double z) { return isInside(skin, u.data(), Vec3(x, y, z), scratch); };
  CHECK(inside(0, 0, 0));
  CHECK(inside(0, 0, -0.9));
  CHECK(inside(0.2, 0, 0.1));
  CHECK(inside(0.2, 0.1, -0.3));
  CHECK_FALSE(inside(0, 0, 1.1));
  CHECK_FALSE(inside(0, 0, -1.1));  // below both
  CHECK_FALSE(inside(0.5, 0, -0.7));
  CHECK_FALSE(inside(0.5, 0.5, -0.1));
  CHECK_FALSE(inside(2, 0, 0));
  for (Float4& a : u) a.z = 3;  // it has gone away
  CHECK_FALSE(inside(0, 0, 0));
  CHECK(inside(0, 0, 3));
  u[4].z = -1.5F;  // its top is pressed through the bottom: what is turned inside out is inside, too
  CHECK_FALSE(inside(0, 0, 3));
  CHECK(inside(0, 0, 1));
}

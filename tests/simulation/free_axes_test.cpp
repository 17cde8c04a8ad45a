#include "setup/free_axes.h"

#include <catch2/catch.hpp>

using namespace palpate;

TEST_CASE("Axes along which nothing is held are free", "[free_axes]") {
  Body body;
  body.imposed = {4, 0, 4, 0};
  CHECK(freeAxes(body) == Vec3(1, 1, 0));
  body.imposed[1] = 2;
  CHECK(freeAxes(body) == Vec3(1, 0, 0));
  body.imposed[1] = 7;
  CHECK(freeAxes(body) == Vec3(0, 0, 0));
  body.imposed.clear();  // nothing is known
  CHECK(freeAxes(body) == Vec3(0, 0, 0));
  body.scene.rigid.emplace_back();
  CHECK(freeAxes(body) == Vec3(1, 1, 1));
}

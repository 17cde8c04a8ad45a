#include "base/turn.h"

#include <catch2/catch.hpp>

using namespace palpate;

TEST_CASE("The z axis is brought upright on a direction by the shortest turn", "[turn]") {
  for (const Vec3& direction : {Vec3(0, 0, 2), Vec3(0, 0, -3), Vec3(1, 2, -3), Vec3(-4, 0, 0), Vec3(1e-9, -1e-9, -1)}) {
    const Quat turn = uprightOn(direction);
    CAPTURE(direction.transpose());
    CHECK(std::abs(turn.norm() - 1) < 1e-12);
    CHECK((turn * Vec3::UnitZ() - direction.normalized()).norm() < 1e-8);
    CHECK(std::abs(turn.z()) < 1e-12);  // about an axis across both: no shorter one does
  }
}

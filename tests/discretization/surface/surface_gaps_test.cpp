#include "discretization/surface/surface_gaps.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "discretization/surface/solids.h"
#include "support/cubes.h"

using namespace palpate;

TEST_CASE("Ways across a slit are known from those around its end and from those through the body", "[surface_gaps]") {
  constexpr double h = 2e-3;
  // A block 24 mm high with a slit of 2 mm half through it.
  const TriangleSurface skin =
      test::cubes({10, 5, 12}, h, [](const Vec3& x) { return x.x() < 5 || x.z() < 6 || x.z() > 7; });
  const SurfaceTree body(skin);
  const SurfaceGaps gaps(skin, body, 0.01);
  REQUIRE_FALSE(gaps.empty());
  const auto at = [&](double x, double y, double z) { return Vec3(x * h, y * h, z * h); };
  for (const double x : {5.5, 8.0, 9.9})  // from corner to corner of the slit, and slanting
    for (const double y : {0.1, 2.5, 4.9}) {
      CHECK(gaps.areBetween(at(x, y, 6), at(x, y, 7)));
      CHECK(gaps.areBetween(at(x, y, 7), at(x, y, 6)));
      CHECK(gaps.areBetween(at(x, y, 3), at(9.5, 2.5, 9)));
      CHECK_FALSE(gaps.areBetween(at(x, y, 3), at(5.5, 2.5, 5.9)));
      CHECK_FALSE(gaps.areBetween(at(x, y, 7), at(5.5, 2.5, 9)));
    }
  // Along the slit's rims, at its mouth and at its sides, and just outside of them, but not around its end.
  for (const double out : {0.0, 0.2}) {
    CHECK(gaps.areBetween(at(10 + out, 2.5, 6), at(10 + out, 2.5, 7)));
    CHECK(gaps.areBetween(at(10 + out, 4, 5), at(10 + out, 1, 8)));
    CHECK(gaps.areBetween(at(7, -out, 6), at(7, -out, 7)));
    CHECK(gaps.areBetween(at(7, 5 + out, 5.5), at(8, 5 + out, 7.5)));
  }
  CHECK_FALSE(gaps.areBetween(at(4.9, 2.5, 6), at(4.9, 2.5, 7)));
  CHECK_FALSE(gaps.areBetween(at(4.5, 2.5, 3), at(4.5, 2.5, 9)));
  CHECK(gaps.areNear(at(8, 2.5, 9), 3 * h));
  CHECK_FALSE(gaps.areNear(at(1, 2.5, 9), 3 * h));
  CHECK(SurfaceGaps(skin, body, 0.5 * h).empty());  // the slit is wider

  // With less below its end than it is wide, what is there stays whole.
  const auto thin = [](const Vec3& x) { return x.x() < 1 || x.z() < 5 || x.z() > 7; };
  const TriangleSurface thin_skin = test::cubes({10, 5, 12}, h, thin);
  CHECK_FALSE(SurfaceGaps(thin_skin, SurfaceTree(thin_skin), 0.01).areBetween(at(0.5, 2.5, 3), at(0.5, 2.5, 9)));
}

TEST_CASE("What bulges, and a corner that looks inward, have no gaps, a cavity does where it is narrow",
          "[surface_gaps]") {
  const auto gapsOf = [](const TriangleSurface& skin) { return SurfaceGaps(skin, SurfaceTree(skin), 0.02); };
  CHECK(gapsOf(boxSurface(Vec3(0.03, 0.02, 0.01), 0.003)).empty());
  CHECK(gapsOf(ellipsoidSurface(Vec3(0.03, 0.02, 0.01), 0.003)).empty());
  CHECK(gapsOf(test::cubes({6, 6, 6}, 0.002, [](const Vec3& x) { return x.x() < 3 || x.z() < 3; })).empty());
  const auto tube = [](const Vec3& x) { return std::abs(x.x() - 4.5) > 1.5 || std::abs(x.z() - 4.5) > 1.5; };
  const SurfaceGaps inside = gapsOf(test::cubes({9, 9, 9}, 0.002, tube));
  CHECK(inside.areBetween(Vec3(0.004, 0.009, 0.009), Vec3(0.014, 0.009, 0.009)));
  CHECK(SurfaceGaps().empty());
  CHECK_FALSE(SurfaceGaps().areBetween(Vec3::Zero(), Vec3::Ones()));
}

TEST_CASE("A body is as thick as where its skin is thinnest, and a little of that does not count", "[surface_gaps]") {
  const SurfaceTree sheet(boxSurface(Vec3(0.06, 0.05, 0.006), 0.003));
  CHECK(thicknessOf(sheet, 0.1) == Approx(0.006));
  CHECK(thicknessOf(sheet, 0.99) == Approx(0.06));
  const SurfaceTree ball(ellipsoidSurface(Vec3::Constant(0.02), 0.003));
  CHECK(thicknessOf(ball, 0.1) == Approx(0.04).epsilon(0.01));
  // A fin of an eighth of the skin on a block.
  const auto fin = [](const Vec3& x) { return x.z() < 10 || x.x() < 1; };
  const SurfaceTree block(test::cubes({10, 10, 14}, 0.002, fin));
  CHECK(thicknessOf(block, 0.1) == Approx(0.002).epsilon(1e-3));
  CHECK(thicknessOf(block, 0.3) == Approx(0.02).epsilon(1e-3));
}

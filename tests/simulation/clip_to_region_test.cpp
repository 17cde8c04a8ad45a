#include "setup/clip_to_region.h"

#include <catch2/catch.hpp>
#include <numbers>

using namespace palpate;

namespace {

// The lower left half of a square of 2 m.
const std::array<Vec3, 3> corner = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)};

Vec3 placeOf(const ClippedTriangle& part) {
  return part.barycentric[0] * corner[0] + part.barycentric[1] * corner[1] + part.barycentric[2] * corner[2];
}

Region regionOf(Region::Kind kind, const Vec3& point, const Vec3& normal = Vec3::UnitX()) {
  Region region;
  region.kind = kind;
  region.point = point;
  region.normal = normal;
  return region;
}

}  // namespace

TEST_CASE("What of a triangle lies in a region has the region's area and middle", "[surface_loads]") {
  Region region = regionOf(Region::Kind::HalfSpace, Vec3(1, 0, 0));
  ClippedTriangle part = clipToRegion(region, corner);
  CHECK(part.share == Approx(0.75));  // all but a triangle of half the edges
  CHECK(placeOf(part).x() == Approx((2.0 * 2 / 3 - 0.5 * 4 / 3) / 1.5));
  region.normal = -region.normal;
  CHECK(clipToRegion(region, corner).share == Approx(0.25));

  region = regionOf(Region::Kind::NearPlane, Vec3(0.5, 0, 0));
  region.distance = 1e-4;
  part = clipToRegion(region, corner);
  CHECK(part.share * 2 == Approx(2e-4 * 1.5).epsilon(1e-4));
  CHECK(placeOf(part).isApprox(Vec3(0.5, 0.75, 0), 1e-4));

  region.kind = Region::Kind::Box;
  region.min = Vec3(0.25, 0.5, -1), region.max = Vec3(0.75, 0.75, 1);
  part = clipToRegion(region, corner);
  CHECK(part.share * 2 == Approx(0.125));
  CHECK(placeOf(part).isApprox(Vec3(0.5, 0.625, 0), 1e-6));
  region.max.z() = -0.5;
  CHECK(clipToRegion(region, corner).share == 0);

  region = regionOf(Region::Kind::Sphere, Vec3(0.5, 0.5, 0.3));
  region.radius = 0.5;
  part = clipToRegion(region, corner);
  CHECK(part.share * 2 == Approx(std::numbers::pi * 0.16).epsilon(1e-6));
  CHECK(placeOf(part).isApprox(Vec3(0.5, 0.5, 0), 1e-6));
  region.radius = 0.29;
  CHECK(clipToRegion(region, corner).share == 0);

  region = regionOf(Region::Kind::Cylinder, Vec3(0, 0, -0.1), Vec3::UnitZ());
  region.radius = 1, region.height = 1;
  CHECK(clipToRegion(region, corner).share * 2 == Approx(std::numbers::pi / 4).epsilon(1e-6));
  region.height = 0.05;
  CHECK(clipToRegion(region, corner).share == 0);
  region.height = 0.1;  // its end is in the plane: as near as rounding
  CHECK(clipToRegion(region, corner).share > 0.3);
}

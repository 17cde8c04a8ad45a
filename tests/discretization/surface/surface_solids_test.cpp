#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "discretization/surface/refine_surface.h"
#include "discretization/surface/solids.h"
#include "discretization/surface/surface_check.h"
#include "discretization/surface/surface_geometry.h"

using namespace palpate;
using std::numbers::pi;

namespace {

struct Quality {
  double smallest_angle = pi;          // rad
  double mean = 0;                     // 1 for equilateral triangles, 0 for flat ones
  double shortest = 1e9, longest = 0;  // edges, m
};

Quality quality(const TriangleSurface& s) {
  Quality q;
  for (const auto& t : s.triangles) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = s.vertices[t[k]], &b = s.vertices[t[(k + 1) % 3]], &c = s.vertices[t[(k + 2) % 3]];
      q.smallest_angle = std::min(q.smallest_angle, std::atan2((b - a).cross(c - a).norm(), (b - a).dot(c - a)));
      q.shortest = std::min(q.shortest, (b - a).norm());
      q.longest = std::max(q.longest, (b - a).norm());
      sum += (b - a).squaredNorm();
    }
    const Vec3 &a = s.vertices[t[0]], &b = s.vertices[t[1]], &c = s.vertices[t[2]];
    q.mean += 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / sum / static_cast<double>(s.triangles.size());
  }
  return q;
}

/// Closed and near-equilateral at the edge length asked for.
void requireGood(const TriangleSurface& s, double edge) {
  checkSurface(s);  // throws where something is wrong
  const Quality q = quality(s);
  CHECK(q.smallest_angle > 25 * pi / 180);
  CHECK(q.mean > 0.94);
  CHECK(q.shortest > 0.5 * edge);
  CHECK(q.longest < 1.5 * edge);
}

constexpr double edges[] = {0.010, 0.004, 0.0027};

}  // namespace

TEST_CASE("Boxes are exact, closed and near-equilateral", "[surface][solids]") {
  for (double edge : edges) {
    const TriangleSurface s = boxSurface({0.1, 0.06, 0.03}, edge);
    requireGood(s, edge);
    CHECK(signedVolume(s) == Approx(0.1 * 0.06 * 0.03).epsilon(1e-12));
  }
}

TEST_CASE("A cylinder has its volume, and vertices outside its mantle by less than faces cut", "[surface][solids]") {
  const double R = 0.04, h = 0.015;
  for (double edge : edges) {
    const TriangleSurface s = cylinderSurface(R, h, edge);
    requireGood(s, edge);
    CHECK(signedVolume(s) == Approx(pi * R * R * h).epsilon(1e-12));
    double farthest = 0;
    for (const Vec3& x : s.vertices) farthest = std::max(farthest, std::hypot(x.x(), x.y()) - R);
    CHECK(farthest > 0);
    CHECK(farthest < edge * edge / (8 * R));
    CHECK(boundingBox(s).max().z() == h);
    CHECK(boundingBox(s).min().z() == 0);
  }
}

TEST_CASE("Ellipsoids have their volume, and vertices outside by less than faces cut", "[surface][solids]") {
  const Vec3 axes(0.04, 0.03, 0.02);
  for (double edge : edges)
    for (const bool half : {false, true}) {
      const TriangleSurface s = half ? halfEllipsoidSurface(axes, edge) : ellipsoidSurface(axes, edge);
      requireGood(s, edge);
      CHECK(signedVolume(s) == Approx((half ? 2.0 : 4.0) / 3 * pi * axes.prod()).epsilon(1e-12));
      double farthest = 0;
      for (const Vec3& x : s.vertices) farthest = std::max(farthest, x.cwiseQuotient(axes).norm() - 1);
      CHECK(farthest > 0);
      CHECK(farthest < edge * edge / (8 * axes.minCoeff() * axes.minCoeff()));
    }
}

TEST_CASE("The half ellipsoid has a flat base and its vertices lie on one ellipsoid", "[surface][solids]") {
  const Vec3 axes(0.04, 0.03, 0.03);
  const TriangleSurface s = halfEllipsoidSurface(axes, 0.004);
  double on = 0;
  for (const Vec3& x : s.vertices) on = std::max(on, x.cwiseQuotient(axes).norm());
  int base = 0, apex = 0;
  for (const Vec3& x : s.vertices) {
    REQUIRE(x.z() >= 0);
    if (x.z() == 0) {
      ++base;
    } else {
      REQUIRE(x.cwiseQuotient(axes).norm() == Approx(on).epsilon(1e-12));
      apex += x.z() > 0.0299;
    }
  }
  CHECK(base > 100);
  CHECK(apex >= 1);
}

TEST_CASE("Coarse and slender solids are still closed", "[surface][solids]") {
  CHECK_NOTHROW(checkSurface(boxSurface({0.1, 0.06, 0.03}, 1.0)));
  CHECK_NOTHROW(checkSurface(boxSurface({0.2, 0.01, 0.003}, 0.004)));
  CHECK_NOTHROW(checkSurface(cylinderSurface(0.01, 0.3, 0.008)));
  CHECK_NOTHROW(checkSurface(cylinderSurface(0.1, 0.002, 0.01)));
  CHECK_NOTHROW(checkSurface(ellipsoidSurface({0.01, 0.04, 0.08}, 0.05)));
  CHECK_NOTHROW(checkSurface(ellipsoidSurface({0.06, 0.04, 0.005}, 0.006)));
  CHECK_NOTHROW(checkSurface(halfEllipsoidSurface({0.04, 0.03, 0.03}, 0.05)));
}

TEST_CASE("Solids refuse lengths that are not", "[surface][solids]") {
  CHECK_THROWS_AS(boxSurface({0.1, 0, 0.1}, 0.01), std::invalid_argument);
  CHECK_THROWS_AS(cylinderSurface(0.1, std::nan(""), 0.01), std::invalid_argument);
  CHECK_THROWS_AS(ellipsoidSurface({1, 1, 1}, -1), std::invalid_argument);
  CHECK_THROWS_AS(boxSurface({1, 1, 1}, 1e-5), std::invalid_argument);  // 5e10 faces
}

TEST_CASE("Refining keeps shape and closedness, meets the length and bounds the angles", "[surface][refine]") {
  const TriangleSurface coarse = cylinderSurface(0.04, 0.015, 0.02);
  const TriangleSurface fine = refineSurface(coarse, 0.003);
  checkSurface(fine);  // throws where something is wrong
  CHECK(signedVolume(fine) == Approx(signedVolume(coarse)).epsilon(1e-12));
  CHECK(surfaceArea(fine) == Approx(surfaceArea(coarse)).epsilon(1e-12));
  CHECK(quality(fine).longest <= 0.003);
  CHECK(quality(fine).smallest_angle >= 0.5 * quality(coarse).smallest_angle - 1e-9);
  CHECK(std::equal(coarse.vertices.begin(), coarse.vertices.end(), fine.vertices.begin()));
  CHECK(refineSurface(coarse, 1.0).triangles == coarse.triangles);
}

TEST_CASE("Refining follows a size function", "[surface][refine]") {
  const TriangleSurface box = boxSurface({0.1, 0.1, 0.02}, 0.05);
  const Vec3 centre(0, 0, 0.02);
  const auto longest_at = [&](const Vec3& x) { return std::max(0.001, 0.3 * (x - centre).norm()); };
  const TriangleSurface fine = refineSurface(box, longest_at);
  checkSurface(fine);  // throws where something is wrong
  double near = 0, far = 0;
  for (const auto& t : fine.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a = fine.vertices[t[k]], &b = fine.vertices[t[(k + 1) % 3]];
      const double length = (b - a).norm();
      REQUIRE(length <= longest_at(0.5 * (a + b)));
      ((a - centre).norm() < 0.003 ? near : far) = std::max((a - centre).norm() < 0.003 ? near : far, length);
    }
  }
  CHECK(near <= 0.0012);
  CHECK(far > 0.01);
  CHECK(fine.triangles.size() < 5000);
}

TEST_CASE("Refining works on open surfaces and refuses what never ends", "[surface][refine]") {
  TriangleSurface triangle;
  triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  const TriangleSurface fine = refineSurface(triangle, 0.3);
  CHECK(surfaceArea(fine) == Approx(0.5).epsilon(1e-12));
  CHECK(quality(fine).longest <= 0.3);
  CHECK_THROWS_AS(refineSurface(triangle, 0.0), std::invalid_argument);
  CHECK_THROWS_AS(refineSurface(
                      triangle, [](const Vec3&) { return 1e-4; }, 1000),
                  std::length_error);
}

#include "discretization/surface/surface_geometry.h"

#include <catch2/catch.hpp>
#include <numbers>
#include <random>

#include "discretization/surface/solids.h"
#include "discretization/surface/surface_tree.h"

using namespace palpate;
using std::numbers::pi;

namespace {

TriangleSurface moved(TriangleSurface surface, const Vec3& by) {
  for (Vec3& x : surface.vertices) x += by;
  return surface;
}

}  // namespace

TEST_CASE("A box has its closed-form area, volume and bounds", "[surface]") {
  const TriangleSurface box = boxSurface({0.1, 0.06, 0.03}, 0.01);
  CHECK(surfaceArea(box) == Approx(2 * (0.1 * 0.06 + 0.06 * 0.03 + 0.03 * 0.1)).epsilon(1e-12));
  CHECK(signedVolume(box) == Approx(0.1 * 0.06 * 0.03).epsilon(1e-12));
  CHECK((boundingBox(box).min() - Vec3(-0.05, -0.03, 0)).norm() < 1e-15);
  CHECK((boundingBox(box).max() - Vec3(0.05, 0.03, 0.03)).norm() < 1e-15);
}

TEST_CASE("A volume keeps its digits far from the origin and turns its sign with the faces", "[surface]") {
  const Vec3 far(1000, -2000, 500);
  TriangleSurface box = moved(boxSurface({0.1, 0.1, 0.1}, 0.05), far);
  // Coordinates of 2000 m are rounded to 2e-13 m, 2e-12 of the box's size.
  CHECK(signedVolume(box) == Approx(1e-3).epsilon(1e-10));
  for (auto& t : box.triangles) std::swap(t[0], t[1]);
  CHECK(signedVolume(box) == Approx(-1e-3).epsilon(1e-10));
}

TEST_CASE("A ball is as round as its radius, whichever way it looks, and a cube about as its edges' angles say",
          "[surface]") {
  TriangleSurface ball = ellipsoidSurface(Vec3::Constant(0.004), 0.0005);
  CHECK(meanRadius(ball) == Approx(0.004).epsilon(0.01));
  for (auto& t : ball.triangles) std::swap(t[0], t[1]);
  CHECK(meanRadius(ball) == Approx(0.004).epsilon(0.01));
  // 12 edges of length a, a quarter of a turn each: 6 a^2 / (12 a pi / 4).
  CHECK(meanRadius(boxSurface({0.01, 0.01, 0.01}, 0.0005)) == Approx(0.02 / pi).epsilon(0.3));
  CHECK(meanRadius(boxSurface({0.1, 0.1, 0.002}, 0.001)) > 0.02);
}

TEST_CASE("Vertex normals are the sphere's, and a cube corner's is its diagonal however faces are cut", "[surface]") {
  const TriangleSurface sphere = ellipsoidSurface({0.05, 0.05, 0.05}, 0.005);
  const std::vector<Vec3> normals = vertexNormals(sphere);
  double worst = 0;
  for (std::size_t v = 0; v < normals.size(); ++v) {
    worst = std::max(worst, (normals[v] - sphere.vertices[v].normalized()).norm());
  }
  CHECK(worst < 0.02);  // second order in edge / radius = 0.1

  const TriangleSurface cube = boxSurface({1, 1, 1}, 1.0);
  const std::vector<Vec3> corner_normals = vertexNormals(cube);
  for (std::size_t v = 0; v < cube.vertices.size(); ++v) {
    const Vec3 outward = (cube.vertices[v] - Vec3(0, 0, 0.5));
    if (outward.cwiseAbs().minCoeff() < 0.49) continue;  // not a corner
    CHECK((corner_normals[v] - outward.normalized()).norm() < 1e-12);
  }
}

TEST_CASE("The closest point of a triangle lies on its face, edge or corner as it should", "[surface]") {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  CHECK((closestBarycentric({0.25, 0.25, 3}, a, b, c) - Vec3(0.5, 0.25, 0.25)).norm() < 1e-15);
  CHECK((closestBarycentric({0.5, -2, 1}, a, b, c) - Vec3(0.5, 0.5, 0)).norm() < 1e-15);
  CHECK((closestBarycentric({2, 2, 0}, a, b, c) - Vec3(0, 0.5, 0.5)).norm() < 1e-15);
  CHECK((closestBarycentric({-1, -1, 0}, a, b, c) - Vec3(1, 0, 0)).norm() < 1e-15);
  CHECK((closestBarycentric({5, 1, 0}, a, b, a) - Vec3(0, 1, 0)).norm() < 1e-15);  // degenerate: a segment
}

TEST_CASE("The tree's closest point and signed distance agree with brute force", "[surface][tree]") {
  const TriangleSurface surface = halfEllipsoidSurface({0.04, 0.03, 0.03}, 0.004);
  const SurfaceTree tree(surface);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.06, 0.06);
  int inside_count = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x(uniform(random), uniform(random), uniform(random));
    double nearest = 1e9, winding = 0;
    for (const auto& [a, b, c] : surface.triangles) {
      const Vec3 &A = surface.vertices[a], &B = surface.vertices[b], &C = surface.vertices[c];
      const Vec3 w = closestBarycentric(x, A, B, C);
      nearest = std::min(nearest, (w[0] * A + w[1] * B + w[2] * C - x).norm());
      const Vec3 p = A - x, q = B - x, r = C - x;
      winding += std::atan2(p.dot(q.cross(r)), p.norm() * q.norm() * r.norm() + p.dot(q) * r.norm() +
                                                   q.dot(r) * p.norm() + r.dot(p) * q.norm()) /
                 (2 * pi);
    }
    const bool inside = winding > 0.5;
    inside_count += inside;
    REQUIRE(tree.closest(x).distance == Approx(nearest).margin(1e-15));
    REQUIRE(tree.signedDistance(x) == Approx(inside ? -nearest : nearest).margin(1e-15));
    REQUIRE(std::abs(tree.windingNumber(x) - winding) < 0.05);
    REQUIRE(tree.closest(x, 0.5 * nearest).triangle == -1);
  }
  CHECK(inside_count > 50);
}

TEST_CASE("A tree so large that its halves are built on different cores is whole", "[surface][tree]") {
  const TriangleSurface sphere = ellipsoidSurface({1, 1, 1}, 0.015);
  REQUIRE(sphere.triangles.size() > 100'000);
  const SurfaceTree tree(sphere);
  for (int k = 0; k < 200; ++k) {
    const Vec3 direction = Vec3(std::sin(2.1 * k), std::sin(3.7 * k + 1), std::sin(5.3 * k + 2)).normalized();
    const double radius = 0.5 + 0.005 * k;
    REQUIRE(tree.closest(radius * direction).distance == Approx(std::abs(radius - 1)).margin(1e-4));
    REQUIRE(tree.windingNumber(radius * direction) == Approx(radius < 1 ? 1 : 0).margin(0.05));
    REQUIRE(tree.firstHit(Vec3::Zero(), direction)->distance == Approx(1).margin(1e-4));
  }
}

TEST_CASE("Inside is right in line with edges and vertices, and close to the skin", "[surface][tree]") {
  const TriangleSurface box = boxSurface({1, 1, 1}, 0.25);
  const SurfaceTree tree(box);
  // All these see vertices and edges exactly along the axes.
  for (double x : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
    for (double y : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
      const bool within = std::abs(x) < 0.5 && std::abs(y) < 0.5;
      if (within) CHECK(tree.inside({x, y, 0.5}));
      CHECK_FALSE(tree.inside({x, y, 1.5}));
      CHECK_FALSE(tree.inside({x, y, -1.0}));
      if (within) {
        CHECK(tree.inside({x, y, 1e-9}));
        CHECK_FALSE(tree.inside({x, y, -1e-9}));
      }
    }
  }
}

TEST_CASE("A cavity's hollow is outside", "[surface][tree]") {
  TriangleSurface shell = ellipsoidSurface({1, 1, 1}, 0.2);
  const TriangleSurface hollow = ellipsoidSurface({0.5, 0.5, 0.5}, 0.1);
  const int offset = static_cast<int>(shell.vertices.size());
  shell.vertices.insert(shell.vertices.end(), hollow.vertices.begin(), hollow.vertices.end());
  for (const auto& [a, b, c] : hollow.triangles) shell.triangles.push_back({a + offset, c + offset, b + offset});
  const SurfaceTree tree(shell);
  CHECK(tree.inside({0.75, 0, 0}));
  CHECK_FALSE(tree.inside({0.1, 0, 0}));
  CHECK_FALSE(tree.inside({1.1, 0, 0}));
  CHECK(tree.signedDistance({0, 0, 0}) == Approx(0.5).epsilon(0.02));
}

TEST_CASE("Rays hit where they should, from either side and through every vertex and edge", "[surface][tree]") {
  const TriangleSurface sphere = ellipsoidSurface({0.05, 0.05, 0.05}, 0.006);
  const SurfaceTree tree(sphere);
  const Vec3 eye(0.3, -0.2, 0.1);
  const auto through = [&](const Vec3& target) {
    const auto hit = tree.firstHit(eye, target - eye);
    REQUIRE(hit.has_value());
    // The first hit is the near side: no further than the target, on the ray, on the surface.
    REQUIRE(hit->distance <= (target - eye).norm() + 1e-12);
    REQUIRE((eye + hit->distance * (target - eye).normalized() - hit->point).norm() < 1e-12);
    REQUIRE(tree.closest(hit->point).distance < 1e-12);
  };
  int grazing = 0;
  for (const Vec3& v : sphere.vertices) {
    // Vertices on the silhouette may be missed by rounding; all others are in the way.
    if (std::abs(v.normalized().dot((v - eye).normalized())) < 0.2) {
      ++grazing;
      continue;
    }
    through(v);
  }
  CHECK(grazing < static_cast<int>(sphere.vertices.size()) / 3);
  for (const auto& [a, b, c] : sphere.triangles) {
    const Vec3 middle = 0.5 * (sphere.vertices[a] + sphere.vertices[b]);
    if (std::abs(middle.normalized().dot((middle - eye).normalized())) > 0.2) through(middle);
  }
  CHECK_FALSE(tree.firstHit(eye, Vec3(0, 0, 1)).has_value());
  CHECK_FALSE(tree.firstHit(eye, -eye, 0.1).has_value());
  CHECK_FALSE(tree.firstHit(eye, Vec3::Zero()).has_value());
  const auto from_within = tree.firstHit(Vec3::Zero(), Vec3(0, 0, 2));
  REQUIRE(from_within.has_value());
  CHECK(from_within->distance == Approx(0.05).epsilon(2e-3));  // faces lie (edge/radius)^2 / 8 below the sphere
}

TEST_CASE("A tree without faces answers that there is nothing", "[surface][tree]") {
  const SurfaceTree tree(TriangleSurface{});
  CHECK(tree.closest(Vec3::Zero()).triangle == -1);
  CHECK_FALSE(tree.inside(Vec3::Zero()));
  CHECK_FALSE(tree.firstHit(Vec3::Zero(), Vec3::UnitX()).has_value());
}

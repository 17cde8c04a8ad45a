#include <catch2/catch.hpp>

#include <cmath>

#include "base/input_error.h"
#include "imaging/remesh.h"
#include "organs/implicit.h"
#include "organs/organ.h"
#include "organs/surface_report.h"

using namespace palpate;
using namespace palpate::organs;

namespace {

Organ ball(double radius, double edge_length) {
  const Vec3 box = Vec3::Constant(radius + 0.01);
  return {"ball", "", -box, box, edge_length, [radius](const Vec3& p) { return p.norm() - radius; }};
}

/// A ring has genus 1: whoever glues or cuts it wrongly shows at once.
Organ ring() {
  return {"ring", "", Vec3(-0.08, -0.08, -0.04), Vec3(0.08, 0.08, 0.04), 0.004, [](const Vec3& p) {
            const double from_circle = std::hypot(p.x(), p.y()) - 0.05;
            return std::hypot(from_circle, p.z()) - 0.018;
          }};
}

TriangleSurface tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

}  // namespace

TEST_CASE("The report knows a tetrahedron by heart", "[organs]") {
  const SurfaceReport report = reportOn(tetrahedron());
  CHECK(report.isClosedSphere());
  CHECK(report.volume == Approx(1.0 / 6).epsilon(1e-14));
  CHECK(report.area == Approx(1.5 + std::sqrt(3.0) / 2).epsilon(1e-14));
  CHECK(report.smallest_angle_deg == Approx(45).epsilon(1e-12));
  CHECK(report.longest_edge == Approx(std::sqrt(2.0)).epsilon(1e-14));
}

TEST_CASE("The report sees what is wrong with a surface", "[organs]") {
  TriangleSurface surface = tetrahedron();
  SECTION("a hole") {
    surface.triangles.pop_back();
    CHECK_FALSE(reportOn(surface).isClosedSphere());
  }
  SECTION("one flipped face") {
    std::swap(surface.triangles[0][0], surface.triangles[0][1]);
    CHECK_FALSE(reportOn(surface).isClosedSphere());
  }
  SECTION("all faces inward") {
    for (auto& t : surface.triangles) std::swap(t[0], t[1]);
    CHECK_FALSE(reportOn(surface).isClosedSphere());
  }
  SECTION("two bodies that touch in a vertex") {
    const TriangleSurface other = tetrahedron();
    for (int v = 1; v < 4; ++v) surface.vertices.push_back(-other.vertices[v]);
    for (const auto& [a, b, c] : other.triangles) {
      const auto moved = [](int v) { return v == 0 ? 0 : v + 3; };
      surface.triangles.push_back({moved(a), moved(c), moved(b)});  // mirrored, so turned
    }
    CHECK(reportOn(surface).volume == Approx(2.0 / 6));
    CHECK_FALSE(reportOn(surface).isClosedSphere());
  }
  SECTION("two pieces") {
    const TriangleSurface other = tetrahedron();
    for (const Vec3& x : other.vertices) surface.vertices.emplace_back(x + Vec3(3, 0, 0));
    for (const auto& [a, b, c] : other.triangles) surface.triangles.push_back({a + 4, b + 4, c + 4});
    CHECK(reportOn(surface).components == 2);
    CHECK_FALSE(reportOn(surface).isClosedSphere());
  }
}

TEST_CASE("Marching tetrahedra close a ball, and its volume converges as the square of the cell", "[organs]") {
  const double radius = 0.03;
  const double exact = 4.0 / 3.0 * M_PI * radius * radius * radius;
  double error[2];
  for (int i = 0; i < 2; ++i) {
    const SurfaceReport report = reportOn(isosurface(ball(radius, 0), i == 0 ? 0.004 : 0.002));
    CHECK(report.isClosedSphere());
    error[i] = exact - report.volume;  // chords lie inside
  }
  CHECK(error[1] > 0);
  CHECK(error[0] / error[1] == Approx(4).margin(1));
}

TEST_CASE("Remeshing keeps topology, makes triangles even and leaves vertices on the surface", "[organs]") {
  const auto [organ, genus] = GENERATE(std::pair(ball(0.03, 0.004), 0), std::pair(ring(), 1));
  const TriangleSurface rough = isosurface(organ, 0.8 * organ.edge_length);
  const TriangleSurface even = remesh(rough, organ.field, organ.edge_length);
  const SurfaceReport before = reportOn(rough);
  const SurfaceReport after = reportOn(even);
  INFO(organ.name << "\nbefore\n" << before.text() << "after\n" << after.text());
  CHECK(before.genus == genus);
  CHECK(after.genus == genus);
  CHECK(after.problem.empty());
  CHECK(after.components == 1);
  CHECK(before.smallest_angle_deg < 10);
  CHECK(after.smallest_angle_deg > 25);
  CHECK(after.mean_edge == Approx(organ.edge_length).epsilon(0.1));
  CHECK(after.longest_edge < 1.6 * organ.edge_length);
  CHECK(after.shortest_edge > 0.5 * organ.edge_length);
  double off_surface = 0;
  for (const Vec3& x : even.vertices) off_surface = std::max(off_surface, std::abs(organ.field(x)));
  CHECK(off_surface < 1e-7);  // where the projection stops
}

TEST_CASE("A surface that reaches its box is refused", "[organs]") {
  Organ cut = ball(0.03, 0.004);
  cut.max.x() = 0.02;
  CHECK_THROWS_AS(isosurface(cut, 0.004), InputError);
}

TEST_CASE("Smooth operations round a corner by half the radius and fade away from it", "[organs]") {
  CHECK(smoothUnion(0, 0, 0.01) == Approx(-0.005));
  CHECK(smoothIntersection(0, 0, 0.01) == Approx(0.005));
  CHECK(smoothUnion(0, 1, 0.01) == Approx(0).margin(1e-4));
  CHECK(smoothDifference(-1, 0.2, 0.01) == Approx(-0.2).margin(1e-4));
}

TEST_CASE("The ellipsoid's field is a distance to first order", "[organs]") {
  const Vec3 axes(0.05, 0.03, 0.02);
  const Vec3 direction = Vec3(1, -2, 3).normalized();
  const Vec3 on = axes.cwiseProduct(direction);  // a point of the surface
  const Vec3 normal = direction.cwiseQuotient(axes).normalized();
  const double h = 1e-5;
  CHECK(std::abs(ellipsoid(on, Vec3::Zero(), axes)) < 1e-15);
  CHECK(ellipsoid(on + h * normal, Vec3::Zero(), axes) == Approx(h).epsilon(1e-2));
  CHECK(ellipsoid(on - h * normal, Vec3::Zero(), axes) == Approx(-h).epsilon(1e-2));
  CHECK(ellipsoid(Vec3::Zero(), Vec3::Zero(), axes) < 0);
}

TEST_CASE("Noise vanishes on its lattice, is bounded, and its slope is continuous there", "[organs]") {
  double largest = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 p(0.137 * i, -0.071 * i, 0.211 * i);
    largest = std::max(largest, std::abs(noise(p, 7)));
  }
  CHECK(largest > 0.3);
  CHECK(largest < 1.5);
  const Vec3 node(3, -2, 5);
  CHECK(noise(node, 7) == 0);
  const double h = 1e-6;
  for (int a = 0; a < 3; ++a) {
    const double before = -noise(node - h * Vec3::Unit(a), 7) / h;
    const double behind = noise(node + h * Vec3::Unit(a), 7) / h;
    CHECK(before == Approx(behind).margin(1e-4));
  }
}

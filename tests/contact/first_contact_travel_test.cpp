#include <catch2/catch.hpp>

#include <cmath>

#include "contact/first_contact_travel.h"
#include "contact/tools/tool_list.h"

using namespace palpate;

namespace {

const ToolShape kTools[] = {{ToolKind::Sphere, 0.01, 0.06, {0.0}},
                            {ToolKind::FlatCylinder, 0.01, 0.06, {0.002}},
                            {ToolKind::Capsule, 0.01, 0.06, {0.0}}};

/// Two triangles, 0.4 m wide, through the origin with the given slope along x.
TriangleSurface plane(double slope) {
  TriangleSurface s;
  for (double x : {-0.2, 0.2}) {
    for (double y : {-0.2, 0.2}) s.vertices.emplace_back(x, y, slope * x);
  }
  s.triangles = {{0, 2, 3}, {0, 3, 1}};
  return s;
}

Pose tipAt(double x, double y, double z) {
  Pose pose;
  pose.position = {x, y, z};
  return pose;
}

}  // namespace

TEST_CASE("Travel to a flat skin between its vertices", "[touch]") {
  for (const ToolShape& tool : kTools) {
    CHECK(firstContactTravel(plane(0.0), tool, tipAt(0.013, -0.02, 0.05)) == Approx(0.05).epsilon(1e-9));
    CHECK(firstContactTravel(plane(0.0), tool, tipAt(0.0, 0.0, -0.002)) == Approx(-0.002).epsilon(1e-9));
    CHECK(std::isinf(firstContactTravel(plane(0.0), tool, tipAt(0.25, 0.0, 0.05))));
  }
}

TEST_CASE("Travel to a sloping skin", "[touch]") {
  // The plane at slope tan(t) is touched where the normals agree: a ball of radius r about (b, z_c) has
  // its centre at height r / cos t over the plane's point below it; the rim's balls stand on the circle
  // of radius R - e, and the uphill one comes first.
  const double slope = 0.5, r_over_cos = std::sqrt(1.0 + slope * slope);
  for (const ToolShape& tool : kTools) {
    const bool flat = tool.kind == ToolKind::FlatCylinder;
    const double ball = flat ? toolProfile(tool).rounding : tool.radius;
    const double offset = flat ? tool.radius - ball : 0.0;
    const double expected = 0.05 - (slope * (0.01 + offset) + ball * r_over_cos - ball);
    CHECK(firstContactTravel(plane(slope), tool, tipAt(0.01, 0.0, 0.05)) == Approx(expected).epsilon(1e-7));
  }
}

TEST_CASE("Travel of a tilted tool to an edge", "[touch]") {
  // A roof whose ridge along y is at z = 0; the tool comes down a direction 30 degrees off the vertical.
  TriangleSurface roof;
  roof.vertices = {{0, -0.2, 0},      {0, 0.2, 0},       {-0.2, -0.2, -0.4},
                   {-0.2, 0.2, -0.4}, {0.2, -0.2, -0.4}, {0.2, 0.2, -0.4}};
  roof.triangles = {{0, 1, 3}, {0, 3, 2}, {0, 4, 5}, {0, 5, 1}};
  Pose start;
  start.orientation = Quat(Eigen::AngleAxisd(M_PI / 6.0, Vec3::UnitX()));
  start.position = start.toWorld({0.004, 0.0, 0.07});  // the axis passes the ridge's middle by 4 mm in x
  const ToolShape& sphere = kTools[0];
  const double h = std::sqrt(sphere.radius * sphere.radius - 0.004 * 0.004);
  // The centre stops where its distance to the ridge (the y axis) is R: sqrt(x^2 + z^2) = R, x = 4 mm.
  const Vec3 centre = start.toWorld({0.0, 0.0, sphere.radius});
  const double expected = (centre.z() - h) / std::cos(M_PI / 6.0);
  CHECK(firstContactTravel(roof, sphere, start) == Approx(expected).epsilon(1e-7));
}

TEST_CASE("Travel to a bumpy skin agrees with dense sampling", "[touch][whole]") {
  TriangleSurface bumps;
  const int n = 24;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = 0.004 * (i - n / 2), y = 0.004 * (j - n / 2);
      bumps.vertices.emplace_back(x, y, 0.004 * std::sin(170 * x + 1) * std::cos(230 * y) + 0.1 * x);
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      bumps.triangles.push_back({v, v + 1, v + n + 2});
      bumps.triangles.push_back({v, v + n + 2, v + n + 1});
    }
  }
  for (const ToolShape& tool : kTools) {
    for (double x : {-0.011, 0.0, 0.017}) {
      Pose start = tipAt(x, 0.003, 0.06);
      start.orientation = Quat(Eigen::AngleAxisd(0.3, Vec3(1, 2, 0).normalized()));
      double sampled = 1.0;
      const int steps = 40;
      for (const auto& t : bumps.triangles) {
        for (int a = 0; a <= steps; ++a) {
          for (int b = 0; a + b <= steps; ++b) {
            const double wa = static_cast<double>(a) / steps, wb = static_cast<double>(b) / steps;
            const Vec3 p = start.toLocal(wa * bumps.vertices[t[0]] + wb * bumps.vertices[t[1]] +
                                         (1.0 - wa - wb) * bumps.vertices[t[2]]);
            sampled = std::min(sampled, tipProfile(tool, std::hypot(p.x(), p.y())) - p.z());
          }
        }
      }
      const double travel = firstContactTravel(bumps, tool, start);
      // Samples 0.1 mm apart miss the minimum by less than the slope there times that.
      CHECK(travel <= sampled + 1e-9);
      CHECK(travel > sampled - 5e-5);
    }
  }
}

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>
#include <string>

#include "contact/bed_motion.h"

using namespace palpate;

// A tool that was added by one file: what holds for every tool, tool_test.cpp sees.

namespace {

constexpr double kHalfAngle = std::numbers::pi / 6.0;  // the default

}  // namespace

TEST_CASE("A cone's distances have their closed forms", "[tool][cone]") {
  ToolShape tool = ToolShape::of(ToolKind::Cone, 0.01);
  tool.parameter[1] = 0.005;
  const double c = std::cos(kHalfAngle), s = std::sin(kHalfAngle);
  // On the cone's side, half way up the taper: a core's point, then out along the side's normal.
  const double wall = 0.005, taper = wall / std::tan(kHalfAngle);
  const Vec3 core(0.5 * wall, 0, 0.005 + 0.5 * taper), out(c, 0, -s);
  struct Case {
    Vec3 x;
    double distance;
    Vec3 normal;
  };
  const Case cases[] = {
      {{0, 0, 0}, 0.0, {0, 0, -1}},         {{0, 0, -0.002}, 0.002, {0, 0, -1}},   {{0, 0, 0.003}, -0.003, {0, 0, -1}},
      {core + 0.005 * out, 0.0, out},       {core + 0.009 * out, 0.004, out},      {core + 0.001 * out, -0.004, out},
      {{0, 0.012, 0.05}, 0.002, {0, 1, 0}}, {{0, 0.001, 0.063}, 0.003, {0, 0, 1}},
  };
  for (const Case& k : cases) {
    CAPTURE(k.x.transpose());
    const ToolDistance d = toolDistance(tool, k.x);
    CHECK(d.distance == Approx(k.distance).margin(1e-15));
    CHECK((d.normal - k.normal).norm() < 1e-12);
  }
}

TEST_CASE("A cone's numbers fit each other, or a fault says which don't", "[tool][cone]") {
  const ToolType& type = toolType(ToolKind::Cone);
  ToolShape tool = ToolShape::of(ToolKind::Cone, 0.01);
  CHECK_FALSE(type.fault(tool));
  tool.parameter[1] = 0.011;
  REQUIRE(type.fault(tool));
  CHECK(std::string(type.fault(tool)->key) == "tip_radius");
  tool.parameter = {10.0, 0.001};  // a taper of 51 mm
  CHECK_FALSE(type.fault(tool));
  tool.length = 0.05;
  REQUIRE(type.fault(tool));
  CHECK(std::string(type.fault(tool)->key) == "length");
  CHECK(std::abs(toolDistance(tool, {0, 0, 0.05}).distance) < 1e-15);  // some surface all the same, as long as asked
}

TEST_CASE("A cone on a Winkler foundation", "[contact][cone][whole]") {
  // F = kappa * (volume below the surface): the cap of the tip up to where the side begins, then a frustum. The
  // discrete bed gives way a node's width h beyond the contact's radius a: an error of order (h / a)^2.
  ToolShape tool = ToolShape::of(ToolKind::Cone, 0.02);
  tool.parameter[1] = 0.01;
  const SpringBed::Spec spec = winkler(0.02, 0.00125);
  SpringBed bed(spec);
  bed.place(tool, tipAt(0.0003, 0.0007, 0));
  move(bed, tool, 100, 0.04 * kDown);
  const Vec3 force = move(bed, tool, 250, Vec3::Zero());
  const double d = -bed.pose.position.z(), e = tool.parameter[1];
  const double cap = e * (1.0 - std::sin(kHalfAngle)), r0 = e * std::cos(kHalfAngle);
  REQUIRE(d > 1.5 * cap);
  const double a = r0 + (d - cap) * std::tan(kHalfAngle);
  const double volume = std::numbers::pi * (cap * cap * (e - cap / 3.0) + (d - cap) * (r0 * r0 + r0 * a + a * a) / 3.0);
  const double error = force.z() / (spec.foundation * volume) - 1.0;
  std::printf("cone on Winkler bed: error %.2f %%\n", 100 * error);
  CHECK(std::abs(error) < 1.3 * std::pow(spec.node_spacing / a, 2));
  CHECK((force - bed.springForce()).norm() < 1e-3 * force.z());
}

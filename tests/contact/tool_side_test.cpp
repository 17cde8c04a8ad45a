#include "contact/tool_side.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "contact/tools/tool_list.h"

using namespace palpate;

namespace {

std::vector<ToolShape> sweptTools() {
  std::vector<ToolShape> tools;
  for (std::size_t k = 0; k < toolTypes().size(); ++k)
    tools.push_back(ToolShape::of(static_cast<ToolKind>(k), 0.01, 0.02));
  tools.push_back({ToolKind::FlatCylinder, 0.01, 0.02, {0.0005}});
  return tools;
}

}  // namespace

TEST_CASE("A point that is swept through a tool leaves where it came in", "[contact][tool_side]") {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (const ToolShape& tool : sweptTools()) {
    CAPTURE(toolType(tool.kind).name);
    const ToolProfile profile = toolProfile(tool);
    int deep_paths = 0, behind = 0;
    for (int path = 0; path < 200; ++path) {
      // Straight through the tool, in by the tip.
      const Vec3 from(0.006 * unit(random), 0.006 * unit(random), -0.002);
      const Vec3 way = Vec3(0.4 * unit(random), 0.4 * unit(random), 1.0).normalized();
      const double step = 1e-2 * tool.radius;
      Vec3f normal = Vec3f::Zero(), side = Vec3f::Zero();
      Vec3 entry = Vec3::Zero(), old = from;
      bool deep = false;
      for (Vec3 x = from; x.z() < 2.2 * tool.radius; x += step * way) {
        const ToolDistance d = distanceBySide(profile, x, old, normal, side);
        REQUIRE(d.normal.norm() == Approx(1.0).epsilon(1e-6));
        if (!side.isZero()) {
          if (!deep) entry = side.cast<double>();
          deep = true;
          REQUIRE(d.normal.dot(entry) > 0.29);
          if (toolDistance(profile, x).normal.dot(entry) < -0.5) ++behind;
        }
        if (d.distance > 0.0 && deep) break;  // it has left
        if (d.distance <= 0.0) normal = d.normal.cast<float>();
        old = x;
      }
      deep_paths += deep ? 1 : 0;
    }
    CHECK(deep_paths > 50);
    CHECK(behind > 100);  // nearest points on the far side, which were not taken
  }
}

TEST_CASE("Near the surface the nearest side is the side, also around a sharp rim", "[contact][tool_side]") {
  const ToolProfile profile = toolProfile({ToolKind::FlatCylinder, 0.01, 0.02, {0.0005}});
  Vec3f side = Vec3f::Zero();
  // From under the end to beside the wall in one step.
  const Vec3 under(0.009, 0, 0.0001), beside(0.0099, 0, 0.004);
  const ToolDistance d = distanceBySide(profile, beside, under, -Vec3f::UnitZ(), side);
  CHECK(d.distance == Approx(-0.0001));
  CHECK((d.normal - Vec3::UnitX()).norm() < 1e-12);
  CHECK(side.isZero());
}

TEST_CASE("A side is forgotten outside, and near the surface where it was entered", "[contact][tool_side]") {
  const ToolProfile profile = toolProfile(ToolShape::of(ToolKind::Sphere, 0.01));
  const auto at = [](double depth) { return Vec3(0, 0, depth); };
  Vec3f side = Vec3f::Zero();
  // Into the middle in one step: the side is where it came from.
  CHECK(distanceBySide(profile, at(0.013), at(-0.001), Vec3f::Zero(), side).distance == Approx(-0.013));
  CHECK((side + Vec3f::UnitZ()).norm() < 1e-6F);
  // Near the far side, not deep any more: still out by the tip.
  CHECK(distanceBySide(profile, at(0.019), at(0.013), -Vec3f::UnitZ(), side).distance == Approx(-0.019));
  CHECK_FALSE(side.isZero());
  SECTION("back at the tip") {
    CHECK(distanceBySide(profile, at(0.001), at(0.019), -Vec3f::UnitZ(), side).distance == Approx(-0.001));
  }
  SECTION("out") { CHECK(distanceBySide(profile, at(0.021), at(0.019), -Vec3f::UnitZ(), side).distance > 0.0); }
  CHECK(side.isZero());
}

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "contact/tools/tool_list.h"

using namespace palpate;

namespace {

const ToolShape kSphere{ToolKind::Sphere, 0.01, 0.06, {0.0}};
const ToolShape kFlat{ToolKind::FlatCylinder, 0.01, 0.06, {0.002}};
const ToolShape kCapsule{ToolKind::Capsule, 0.01, 0.06, {0.0}};

/// Each tool there is, thick and slim.
std::vector<ToolShape> allTools() {
  std::vector<ToolShape> tools{kFlat};
  for (std::size_t k = 0; k < toolTypes().size(); ++k) {
    for (double radius : {0.01, 0.004}) tools.push_back(ToolShape::of(static_cast<ToolKind>(k), radius));
  }
  return tools;
}

double rim(const ToolShape& tool) { return toolProfile(tool).rounding; }

Vec3 randomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> side(-0.02, 0.02), axis(-0.02, 0.08);
  return {side(random), side(random), axis(random)};
}

Vec3 finiteDifference(const ToolShape& tool, const Vec3& x, double h) {
  Vec3 gradient;
  for (int c = 0; c < 3; ++c) {
    const Vec3 step = h * Vec3::Unit(c);
    gradient[c] = (toolDistance(tool, x + step).distance - toolDistance(tool, x - step).distance) / (2.0 * h);
  }
  return gradient;
}

}  // namespace

TEST_CASE("Tool distances have their closed forms", "[tool]") {
  struct Case {
    ToolShape tool;
    Vec3 x;
    double distance;
    Vec3 normal;
  };
  const double s = std::sqrt(0.5);
  const Case cases[] = {
      {kSphere, {0, 0, 0}, 0.0, {0, 0, -1}},
      {kSphere, {0, 0, -0.004}, 0.004, {0, 0, -1}},
      {kSphere, {0.013, 0, 0.01}, 0.003, {1, 0, 0}},
      {kSphere, {0, 0, 0.01}, -0.01, {0, 0, -1}},  // the centre: out is forwards
      {kFlat, {0.003, 0.004, 0}, 0.0, {0, 0, -1}},
      {kFlat, {0, 0.007, -0.005}, 0.005, {0, 0, -1}},
      {kFlat, {0, -0.012, 0.03}, 0.002, {0, -1, 0}},
      {kFlat, {0, 0, 0.003}, -0.003, {0, 0, -1}},
      {kFlat, {0.009, 0, 0.03}, -0.001, {1, 0, 0}},
      {kFlat, {0, 0, 0.061}, 0.001, {0, 0, 1}},
      // On the rim's diagonal, 3 mm from the circle of its centres.
      {kFlat, {0.008 + 0.003 * s, 0, 0.002 - 0.003 * s}, 0.001, {s, 0, -s}},
      {kCapsule, {0, 0, -0.001}, 0.001, {0, 0, -1}},
      {kCapsule, {0.012, 0, 0.04}, 0.002, {1, 0, 0}},
      {kCapsule, {0, 0, 0.065}, 0.005, {0, 0, 1}},
      {kCapsule, {0, 0.004, 0.03}, -0.006, {0, 1, 0}},
  };
  for (const Case& c : cases) {
    CAPTURE(static_cast<int>(c.tool.kind), c.x.transpose());
    const ToolDistance d = toolDistance(c.tool, c.x);
    CHECK(d.distance == Approx(c.distance).margin(1e-15));
    CHECK((d.normal - c.normal).norm() < 1e-12);
  }
}

TEST_CASE("Tool normals are the distance's gradient, and both are exact", "[tool]") {
  std::mt19937 random(7);
  for (const ToolShape& tool : allTools()) {
    CAPTURE(static_cast<int>(tool.kind));
    double worst_gradient = 0.0, worst_foot = 0.0;
    int points = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random), y = randomPoint(random);
      const ToolDistance d = toolDistance(tool, x);
      // A distance changes by no more than the way between two points.
      REQUIRE(std::abs(d.distance - toolDistance(tool, y).distance) <= (x - y).norm() + 1e-15);
      REQUIRE(d.normal.norm() == Approx(1.0).epsilon(1e-12));
      if (d.distance < -0.9 * toolProfile(tool).rounding) continue;
      ++points;
      // The foot of x stands on the surface with the same normal.
      const ToolDistance foot = toolDistance(tool, x - d.distance * d.normal);
      worst_foot = std::max({worst_foot, std::abs(foot.distance) / tool.radius, (foot.normal - d.normal).norm()});
      // Central differences: the third derivative is at most ~ 1 / (0.1 e)^2, e >= 1.2 mm; seams are C1,
      // where the error is h times the jump of curvature, at most 1 / (0.1 e).
      worst_gradient = std::max(worst_gradient, (finiteDifference(tool, x, 1e-8) - d.normal).norm());
    }
    CHECK(points > 10000);
    CHECK(worst_foot < 1e-12);
    CHECK(worst_gradient < 1e-4);
  }
}

TEST_CASE("Tool normals turn continuously down to the smooth depth", "[tool]") {
  std::mt19937 random(11);
  for (const ToolShape& tool : allTools()) {
    const double h = 1e-6;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random);
      const ToolDistance d = toolDistance(tool, x);
      if (d.distance < -0.8 * toolProfile(tool).rounding) continue;
      // The smallest radius of curvature there is 0.2 of the rounding.
      const Vec3 turn = toolDistance(tool, x + h * randomPoint(random).normalized()).normal - d.normal;
      REQUIRE(turn.norm() <= 1.1 * h / (0.2 * toolProfile(tool).rounding));
    }
  }
}

TEST_CASE("The way out of a tool along a direction", "[tool]") {
  CHECK(exitDistance(toolProfile(kFlat), {0.003, 0, 0.004}, -Vec3::UnitZ()) == Approx(0.004).epsilon(1e-3));
  CHECK(exitDistance(toolProfile(kFlat), {0.003, 0, 0.03}, Vec3::UnitX()) == Approx(0.007).epsilon(1e-3));
  // A chord of the sphere: height c over the centre plane, half chord sqrt(R^2 - c^2).
  CHECK(exitDistance(toolProfile(kSphere), {0, 0.006, 0.01}, Vec3::UnitX()) == Approx(0.008).epsilon(1e-3));
  CHECK(exitDistance(toolProfile(kCapsule), {0, 0, 0.03}, -Vec3::UnitZ()) == Approx(0.03).epsilon(1e-3));
  CHECK(exitDistance(toolProfile(kSphere), {0, 0, -0.001}, -Vec3::UnitZ()) == 0.0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(exitDistance(toolProfile(kSphere), {nan, 0, 0}, -Vec3::UnitZ()) == 0.0);
}

TEST_CASE("The tip's profile lies on the surface", "[tool]") {
  for (const ToolShape& tool : allTools()) {
    for (double r = 0.0; r <= tool.radius; r += 0.05 * tool.radius) {
      CHECK(std::abs(toolDistance(tool, {0.6 * r, 0.8 * r, tipProfile(tool, r)}).distance) < 1e-15);
      // It is the leading side: below it the tool isn't.
      CHECK(toolDistance(tool, {0.6 * r, 0.8 * r, tipProfile(tool, r) - 1e-6}).distance > 0.0);
    }
    CHECK(std::isinf(tipProfile(tool, 1.01 * tool.radius)));
  }
}

TEST_CASE("A tip touches as the ball of its touch radius does", "[tool]") {
  const double R = 0.01;
  CHECK(touchRadius(ToolShape::of(ToolKind::FlatCylinder, R)) == R);
  for (const ToolKind kind : {ToolKind::Sphere, ToolKind::Capsule, ToolKind::Cone})
    for (const double tip : {0.5, 0.7, 1.0}) {
      ToolShape tool = ToolShape::of(kind, R);
      if (kind == ToolKind::Cone) tool.parameter[1] = tip * R;
      CAPTURE(toolType(kind).name, tip);
      // Sneddon's depth at which the profile f touches a disk of radius a: integral of a f'(r) / sqrt(a^2 - r^2).
      const double a = touchRadius(tool) / 2;
      const int count = 400;
      double depth = 0;
      for (int k = 0; k < count; ++k) {
        const double step = std::numbers::pi / 2 / count, r = a * std::sin((k + 0.5) * step);
        depth += a * step * (tipProfile(tool, r + 1e-7) - tipProfile(tool, r - 1e-7)) / 2e-7;
      }
      CHECK(depth == Approx(R / 4).epsilon(0.25));
    }
}

TEST_CASE("A tool's shorter formula is the general one of its profile", "[tool]") {
  std::mt19937 random(13);
  int shorter = 0;
  for (const ToolShape& tool : allTools()) {
    const ToolProfile profile = toolProfile(tool);
    shorter += profile.closed_form != nullptr;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = randomPoint(random);
      const ToolDistance a = toolDistance(profile, x), b = generalDistance(profile, x);
      REQUIRE(std::abs(a.distance - b.distance) < 1e-15);
      if (a.distance > -0.9 * profile.rounding) REQUIRE((a.normal - b.normal).norm() < 1e-11);
    }
  }
  CHECK(shorter >= 2);  // flat cylinders
}

TEST_CASE("A tool's outline lies on its surface, from the tip to the end, outside on the right", "[tool]") {
  for (const ToolShape& tool : allTools()) {
    CAPTURE(toolType(tool.kind).name, tool.radius);
    const ToolProfile profile = toolProfile(tool);
    const std::vector<MeridianPoint> points = outline(profile);
    REQUIRE(points.size() >= 10);
    double widest = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const MeridianPoint p = points[k];
      const ToolDistance d = toolDistance(profile, {0.6 * p.r, 0.8 * p.r, p.z});
      REQUIRE(std::abs(d.distance) < 1e-15);
      widest = std::max(widest, p.r);
      if (k == 0) continue;
      const MeridianPoint q = points[k - 1];
      REQUIRE((p.z >= q.z || p.r < 1e-15));
      // The middle of a piece lies in the tool, and no deeper than shows.
      const double depth = -toolDistance(profile, {0.5 * (p.r + q.r), 0, 0.5 * (p.z + q.z)}).distance;
      REQUIRE(depth > -1e-15);
      REQUIRE(depth < 0.0065 * tool.radius);
    }
    CHECK(std::hypot(points.front().r, points.front().z) < 1e-15);
    CHECK(std::hypot(points.back().r, points.back().z - profile.length) < 1e-15);
    CHECK(widest == Approx(tool.radius).epsilon(1e-12));
    CHECK(profile.radius == tool.radius);
  }
}

TEST_CASE("Tools have names and parameters that a scene can say", "[tool]") {
  std::set<std::string> names;
  for (const ToolType* type : toolTypes()) {
    CAPTURE(type->name);
    CHECK(names.insert(type->name).second);
    CHECK(type->parameters.size() <= ToolShape::max_parameters);
    std::set<std::string> keys{"shape", "radius", "length", "position", "direction", "max_speed", "friction"};
    for (const Parameter& parameter : type->parameters) {
      CHECK(keys.insert(parameter.name).second);
      CHECK(parameter.type == Parameter::Type::Number);
      REQUIRE_FALSE(parameter.isRequired());
      CHECK(parameter.range.contains(parameter.fallbackValue()));
    }
    // A tool with its defaults is a tool.
    const auto kind = static_cast<ToolKind>(names.size() - 1);
    CHECK(&toolType(kind) == type);
    CHECK_FALSE(type->fault(ToolShape::of(kind, 0.01)).has_value());
  }
}

TEST_CASE("A default rounding is as its text says", "[tool]") {
  int roundings = 0;
  for (std::size_t k = 0; k < toolTypes().size(); ++k) {
    for (const Parameter& parameter : toolTypes()[k]->parameters) {
      const std::string text = parameter.text, mark = "0: ";
      const std::size_t at = text.find(mark), end = text.find(" of the radius");
      if (at == std::string::npos || end == std::string::npos) continue;
      ++roundings;
      const double share = std::stod(text.substr(at + mark.size(), end - at - mark.size()));
      CHECK(parameter.fallbackValue() == 0.0);
      CHECK(rim(ToolShape::of(static_cast<ToolKind>(k), 0.01)) == Approx(share * 0.01));
    }
  }
  CHECK(roundings >= 1);  // the flat cylinder's
}

TEST_CASE("The rim is no rounder than the cylinder allows", "[tool]") {
  CHECK(rim({ToolKind::FlatCylinder, 0.01, 0.06, {0.0}}) == Approx(default_rounding_per_radius * 0.01));
  CHECK(rim({ToolKind::FlatCylinder, 0.01, 0.06, {0.02}}) == Approx(0.01));
  CHECK(rim({ToolKind::FlatCylinder, 0.01, 0.006, {0.02}}) == Approx(0.003));
}

TEST_CASE("No point of a tool travels further than the bound", "[tool]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Pose from, to;
    from.orientation = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    to.orientation = Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
    to.position = 0.01 * Vec3(normal(random), normal(random), normal(random));
    const double bound = largestTravel(kFlat, from, to);
    for (const Vec3& x : {Vec3(0, 0, 0), Vec3(0.01, 0, 0.06), Vec3(0, -0.01, 0.06), Vec3(-0.01, 0, 0)}) {
      REQUIRE((to.toWorld(x) - from.toWorld(x)).norm() <= bound * (1.0 + 1e-12));
    }
  }
}

#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>

#include "base/key.h"
#include "contact/bed_motion.h"
#include "support/realtime_guard.h"

using namespace palpate;

// Speed, depth, bad numbers, and what the real-time thread needs.

namespace {

std::uint64_t hashOf(const SpringBed& bed) {
  const auto bytes = [](const AlignedVector<Float4>& a) {
    return std::string_view(reinterpret_cast<const char*>(a.data()), a.size() * sizeof(Float4));
  };
  return fnv1a(bytes(bed.du), fnv1a(bytes(bed.u)));
}

}  // namespace

TEST_CASE("Nothing tunnels at 1 and 2 m/s", "[contact]") {
  for (ToolKind kind : kKinds) {
    for (double radius : {0.01, 0.003}) {
      for (double speed : {1.0, 2.0}) {
        for (double tilt : {0.0, 0.7, M_PI / 2}) {  // tip first, askew, and flat with its side
          CAPTURE(static_cast<int>(kind), radius, speed, tilt);
          SpringBed::Spec spec = tissueLike();
          spec.tool_radius = radius;
          spec.skin_spacing = std::min(0.0025, 0.3 * radius);
          SpringBed bed(spec);
          const ToolShape tool = toolOf(kind, radius);
          Pose start;
          start.orientation = Quat(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
          const double middle = kind == ToolKind::Sphere ? radius : 0.5 * tool.length;
          start.position = Vec3(0.0003, 0.0007, 0.02) - (tilt > 1.0 ? middle : 0.0) * Vec3::UnitX();
          bed.place(tool, start);
          double deepest = 0.0;
          for (int k = 0; k < 0.035 / speed / 0.002; ++k) {
            move(bed, tool, 1, speed * kDown);
            deepest = std::max(deepest, bed.deepest(tool));
          }
          // A vertex that got past the middle would be deeper than half the radius on its way.
          CHECK(deepest < 0.3 * radius);
          CHECK(deepest > 0.0);
          // The skin below the tool is still below it.
          const Vec3 tip = bed.pose.toWorld({0, 0, radius});
          for (int v = 0; v < bed.skin.vertexCount(); ++v) {
            const Vec3 x = skinPosition(bed.skin, v, bed.u.data());
            if ((x - tip).head<2>().norm() < 0.5 * radius) REQUIRE(x.z() < tip.z());
          }
          REQUIRE(allFinite(bed.u));
        }
      }
    }
  }
}

TEST_CASE("A vertex deep under a flat end is pushed out by the end, not by the wall", "[contact]") {
  const ToolShape tool{ToolKind::FlatCylinder, 0.01, 0.06, {0.0005}};
  SpringBed::Spec spec = tissueLike();
  spec.skin_spacing = 0.001;
  SpringBed bed(spec);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.0005));
  findContactCandidates(bed.skin, bed.u.data(), tool, bed.pose, 0.01, bed.contact, bed.scratch);
  // In one step 3 mm below the skin: vertices within 3 mm of the wall are nearer to it than to the end.
  bed.step(tool, tipAt(0.0003, 0.0007, -0.003));
  int near_wall = 0;
  for (int step = 0; step < 20; ++step) {
    for (int k = 0; k < bed.contact.count; ++k) {
      const Vec3 local = bed.pose.toLocal(bed.skin.surface.vertices[bed.contact.vertex[k]]);
      const double r = local.head<2>().norm();
      if (r > tool.radius - 2.0 * toolProfile(tool).rounding) continue;
      near_wall += r > tool.radius - 0.0025 ? 1 : 0;
      const Vec3 force = toVec3(bed.contact.force[k]);
      REQUIRE(force.head<2>().norm() <= 1e-3 * force.norm());
      REQUIRE(force.z() <= 0.0);
    }
    bed.step(tool, bed.pose);
  }
  CHECK(near_wall > 100);
  move(bed, tool, 400, Vec3::Zero());  // it is thrown off and returns
  CHECK(bed.deepest(tool) < 0.02 * tool.radius);
}

TEST_CASE("A tool put deep into the tissue is survived", "[contact]") {
  for (ToolKind kind : kKinds) {
    SpringBed bed(tissueLike());
    const ToolShape tool = toolOf(kind);
    bed.place(tool, tipAt(0, 0, 0.1));
    bed.tick(tool, tipAt(0.0, 0.0, -0.02), 1, 0.3);
    for (int k = 0; k < 200; ++k) REQUIRE(move(bed, tool, 1, Vec3::Zero(), 0.3).allFinite());
    CHECK(allFinite(bed.u));
    bed.tick(tool, tipAt(0.0, 0.0, 0.1), 1, 0.3);
    move(bed, tool, 500, Vec3::Zero(), 0.3);
    double largest = 0.0;
    for (const Float4& a : bed.u) largest = std::max(largest, toVec3(a).norm());
    std::printf("teleport: kind %d: largest displacement a second later %.2e m\n", static_cast<int>(kind), largest);
    CHECK(largest < 0.03);
  }
}

TEST_CASE("What is not a number stays where it is", "[contact]") {
  SpringBed bed(tissueLike());
  const ToolShape tool = toolOf(ToolKind::Sphere);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.0));
  move(bed, tool, 200, 0.01 * kDown, 0.3);
  const int bad = (bed.side / 2) * bed.side + bed.side / 2 + 2;  // beside the contact's middle
  bed.u[bad].x = std::numeric_limits<float>::quiet_NaN();
  const Vec3 force = bed.step(tool, bed.pose, 0.3);
  CHECK(force.allFinite());
  CHECK(force.z() > 0.0);
  bed.du[0].y = std::numeric_limits<float>::infinity();
  const Vec3 lost = bed.solve(tool, bed.pose, bed.pose, 0.3, 4e-8);
  CHECK(lost.allFinite());
  for (Float4& a : bed.du) a.z = std::numeric_limits<float>::quiet_NaN();
  CHECK(bed.step(tool, bed.pose, 0.3).norm() == 0.0);
}

TEST_CASE("Contact is deterministic and does not see how far the search went", "[contact]") {
  auto run = [](double margin) {
    SpringBed bed(tissueLike());
    const ToolShape tool = toolOf(ToolKind::FlatCylinder);
    bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
    for (int k = 0; k < 400; ++k) {
      const Pose from = bed.pose;
      findContactCandidates(bed.skin, bed.u.data(), tool, from, margin, bed.contact, bed.scratch);
      for (int s = 0; s < 5; ++s) {
        Pose to = bed.pose;
        to.position += k < 200 ? Vec3(0, 0, -2e-6) : Vec3(2e-6, 1e-6, 0);
        bed.step(tool, to, 0.3);
      }
    }
    return hashOf(bed);
  };
  const std::uint64_t hash = run(0.0005);
  CHECK(run(0.0005) == hash);
  CHECK(run(0.004) == hash);
}

TEST_CASE("Contact allocates nothing and locks nothing", "[contact]") {
  if (!test::guardAvailable()) {
    WARN("a sanitizer replaces malloc: not counted here");
    return;
  }
  SpringBed bed(tissueLike());
  const ToolShape tool = toolOf(ToolKind::FlatCylinder);
  bed.place(tool, tipAt(0.0003, 0.0007, 0.001));
  test::startGuard();
  for (int k = 0; k < 200; ++k) move(bed, tool, 1, {0.01, 0.0, -0.01}, 0.3);
  const int offences = test::stopGuard().total();
  CHECK(offences == 0);
  CHECK(bed.contact.contact_count > 5);
  // The guard counts.
  test::startGuard();
  const auto some = std::make_unique<SpringBed>(bed);
  const int allocations = test::stopGuard().allocations;
  CHECK(allocations > 0);
  CHECK(some->side == bed.side);
}

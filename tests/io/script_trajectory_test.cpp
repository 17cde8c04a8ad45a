#include "io/script_trajectory.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "base/turn.h"

using namespace palpate;

namespace {

constexpr double touch = 0.03;  // m from the start pose to the skin

Pose tiltedStart() {
  Pose start;
  start.position = Vec3(0.1, -0.2, 0.3);
  start.orientation = uprightOn(Vec3(-1, -2, 3));
  return start;
}

/// Down, aside and up again, with corners in the middle of ticks and one that is shorter than the mean's reach.
ToolScript dragAndLift(bool smooth) {
  ToolScript script;
  script.smooth = smooth;
  script.keyframes = {
      {0.1234, 0, {0, 0}}, {0.4, 0.005, {0.001, 0}}, {0.41, 0.006, {0.003, -0.002}}, {0.7777, -0.01, {0.01, 0.02}}};
  return script;
}

/// The definition, all positions at once: the mean of those within 20 ms, as many at the end as the mean reaches.
std::vector<Vec3> allAtOnce(const ToolScript& script, const Pose& start, double rate) {
  const long reach = std::lround(0.02 * rate);
  std::vector<Vec3> own;
  for (long k = 1; k <= std::lround(std::ceil(script.duration() * rate)); ++k)
    own.push_back(poseAt(script, start, touch, static_cast<double>(k) / rate).position);
  own.insert(own.end(), static_cast<std::size_t>(reach), own.back());
  const long count = static_cast<long>(own.size());
  std::vector<Vec3> rounded;
  for (long k = 0; k < count; ++k) {
    const long r = std::min(reach, k);
    Vec3 sum = Vec3::Zero();
    for (long j = k - r; j <= k + r; ++j) sum += own[static_cast<std::size_t>(std::min(j, count - 1))];
    rounded.emplace_back(sum / static_cast<double>(2 * r + 1));
  }
  return rounded;
}

}  // namespace

TEST_CASE("A script followed tick by tick goes where it goes all at once, bit for bit, and again after a restart",
          "[io][tool]") {
  const Pose start = tiltedStart();
  for (const bool smooth : {true, false})
    for (const double rate : {100.0, 500.0, 777.0, 2000.0}) {
      const std::vector<Vec3> expected = allAtOnce(dragAndLift(smooth), start, rate);
      ScriptTrajectory trajectory(dragAndLift(smooth), start, touch, rate);
      REQUIRE(trajectory.ticks() == static_cast<std::int64_t>(expected.size()));
      for (int k = 0; k < 37; ++k) trajectory.next();
      trajectory.restart();
      for (const Vec3& position : expected) {
        const Pose pose = trajectory.next();
        REQUIRE(std::memcmp(pose.position.data(), position.data(), 3 * sizeof(double)) == 0);
        REQUIRE(pose.orientation.coeffs() == start.orientation.coeffs());
      }
      for (int k = 0; k < 100; ++k) REQUIRE(trajectory.next().position == expected.back());  // it stays there
    }
}

TEST_CASE("A script of twelve days is followed without memory for it", "[io][tool]") {
  ToolScript script;
  script.keyframes = {{1, 0, {0, 0}}, {1e6, 0.01, {0, 0}}};
  ScriptTrajectory trajectory(script, tiltedStart(), touch, 2000);
  CHECK(trajectory.ticks() == 2'000'000'000 + 40);
  Vec3 before = trajectory.next().position;
  double way = 0;
  for (int k = 0; k < 5000; ++k) {
    const Vec3 now = trajectory.next().position;
    way += (now - before).norm();
    before = now;
  }
  CHECK(way == Approx(touch).epsilon(1e-6));  // a second down to the skin; then it hardly moves for days
}

#include "app/run/rough_motion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <utility>
#include <vector>

#include "app/run/rough_report.h"
#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// A coarse block of two materials, the upper third half as stiff.
Model twoLayers() {
  Scene scene = test::blockScene(0.015);
  scene.materials.push_back(scene.materials[0]);
  MaterialSpec& top = scene.materials[1];
  top.material.set("young", 1500);
  top.everywhere = false;
  top.region.kind = Region::Kind::HalfSpace;
  top.region.point = Vec3(0, 0, 0.02);
  top.region.normal = -Vec3::UnitZ();
  return test::blockModel(scene);
}

}  // namespace

TEST_CASE("Under a rough hand the tissue is always there, always finite, and comes back to rest",
          "[rough_motion][whole]") {
  const Model model = twoLayers();
  std::vector<std::uint64_t> hashes;
  for (const unsigned seed : {1u, 2u, 2u}) {
    const bool long_run = seed == 1;  // the others show that the seed alone makes the run
    TissuePhysics physics(model, 1);
    RoughMotion motion(model, seed);
    SimulationLoopOptions options;
    options.motion = &motion;
    options.tick_limit = long_run ? 5000 : 1200;
    SimulationLoop loop(model, physics, nullptr, options);
    test::FakeClock clock;
    double deepest = 0;
    int settings = 0;
    double friction = model.scene.tools[0].friction;
    clock.before_sleep = [&](int) {
      deepest = std::max(deepest, 0.03 - loop.snapshots().latest().hand_pose.position.z());
      settings += std::exchange(friction, physics.state().live.friction[0]) != friction;
    };
    loop.run(clock);
    const RunSummary& summary = loop.summary();
    const SoakReport report = test::roughReport(motion, summary);
    INFO("seed " << seed << ", " << report.cycles << " cycles, restored " << report.restored << ", min J "
                 << report.min_J << ", drift " << report.largest_drift_m << " m");
    CHECK(report.not_finite == 0);
    CHECK_FALSE(summary.frozen);
    hashes.push_back(summary.state_hash);
    if (!long_run) continue;
    CHECK(brokenPromises(report).empty());
    CHECK(report.cycles >= 1);
    CHECK(deepest > 0.02);
    CHECK(settings >= 1);
    CHECK(summary.peak_force > 0.3);
  }
  CHECK(hashes[1] == hashes[2]);
}

TEST_CASE("A rough hand whose tool the organ lies on leaves downwards", "[rough_motion]") {
  const Model model = test::smallModel();
  RoughMotion motion(model, 1);
  const State state = initialState(model);
  StepReport touched;
  touched.contact_count = 3;
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  for (const Vec3& X : model.skin.surface.vertices) {
    low = low.cwiseMin(X);
    high = high.cwiseMax(X);
  }
  const double far = 0.9 * (high - low).norm();
  double highest = 0;
  SoakCycle cycle;
  int ticks = 0;
  for (const int most = static_cast<int>(30 * model.scene.dynamics.rate_hz); !motion.cycles().pop(cycle); ++ticks) {
    REQUIRE(ticks < most);
    const double z = motion.next(state, touched).position.z();
    highest = std::max(highest, z);
    if (highest > high.z() + far && z < low.z() - far) touched.contact_count = 0;  // freed
  }
  CHECK(touched.contact_count == 0);
  CHECK(cycle.rested);
}

TEST_CASE("The rough hand neither allocates nor locks", "[rough_motion]") {
  if (!test::guardAvailable()) return;
  const Model model = test::smallModel();
  test::FakePhysics physics(model);
  RoughMotion motion(model, 1);
  SimulationLoopOptions options;
  options.motion = &motion;
  options.tick_limit = 5000;
  SimulationLoop loop(model, physics, nullptr, options);
  test::FakeClock clock;
  test::startGuard();
  loop.run(clock);
  const test::GuardCounts counts = test::stopGuard();
  CHECK(counts.total() == 0);
  CHECK(motion.cycles().size() >= 2);
}

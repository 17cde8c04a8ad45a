// The loop on real tissue: a small block pressed by a sphere.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "contact/tools/tool_list.h"
#include "discretization/surface/solids.h"
#include "model/model_hash.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"
#include "realtime/team_guard.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "support/realtime_guard.h"

using namespace palpate;

namespace {

/// 40 x 40 x 20 mm on a fixed base, a sphere 1 mm above it.
const Model& block() {
  static const Model model = [] {
    Scene scene;
    scene.name = "block";
    scene.discretization.spacing = 0.01;
    scene.materials = {MaterialSpec{}};
    BoundarySpec base;
    base.region.kind = Region::Kind::HalfSpace;
    base.region.point = Vec3::Zero();
    base.region.normal = Vec3::UnitZ();
    scene.boundaries = {base};
    scene.tools[0].shape.kind = ToolKind::Sphere;
    scene.tools[0].shape.radius = 0.008;
    scene.tools[0].position = Vec3(0, 0, 0.021);
    scene.tools[0].friction = 0.3;
    return buildModel(scene, boxSurface(Vec3(0.04, 0.04, 0.02), 0.005));
  }();
  return model;
}

/// Down 4 mm, then sideways.
std::vector<TimedRequest> pressAndDrag(int ticks) {
  std::vector<Pose> poses;
  for (int k = 1; k <= ticks; ++k) {
    const double down = std::min(1.0, 2.0 * k / ticks), along = std::max(0.0, 2.0 * k / ticks - 1);
    Pose pose = block().tools.first().start.pose;
    pose.position += Vec3(0.005 * along, 0, -0.004 * down);
    poses.push_back(pose);
  }
  return test::trackFromPoses(poses);
}

SimulationLoopOptions pressing(int ticks, bool fast = true) {
  SimulationLoopOptions options;
  options.as_fast_as_possible = fast;
  options.tick_limit = ticks;
  options.track = pressAndDrag(ticks);
  return options;
}

RunSummary run(TissuePhysics& physics, const Model& model, const SimulationLoopOptions& options) {
  SimulationLoop loop(model, physics, &physics.team(), options);
  loop.start();
  loop.join();
  return loop.summary();
}

bool sameBits(const AlignedVector<Float4>& a, const AlignedVector<Float4>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Float4)) == 0;
}

}  // namespace

TEST_CASE("A press gives the same state on 1, 2 and 3 threads, in real time or not", "[tissue_physics]") {
  constexpr int ticks = 60;
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 3}) {
    for (const bool fast : {true, false}) {
      const Model& model = block();
      TissuePhysics physics(model, threads);
      const RunSummary summary = run(physics, model, pressing(ticks, fast));
      CHECK(summary.ticks == ticks);
      CHECK(summary.peak_force > 0.05);  // it does touch
      CHECK((summary.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0);
      hashes.push_back(summary.state_hash);
    }
  }
  for (const std::uint64_t hash : hashes) CHECK(hash == hashes[0]);
}

TEST_CASE("Reset equals a fresh load, bit for bit, and so does what follows", "[tissue_physics]") {
  const Model& model = block();
  TissuePhysics physics(model, 1);
  const RunSummary first = run(physics, model, pressing(40));
  CHECK(first.peak_force > 0.05);
  physics.reset();
  const State fresh = initialState(block());
  CHECK(sameBits(physics.state().u, fresh.u));
  CHECK(sameBits(physics.state().du, fresh.du));
  CHECK(sameBits(physics.state().u_low, fresh.u_low));
  CHECK(physics.state().tick == 0);
  CHECK(physics.state().step == 0);
  CHECK(physics.state().contact[0].count == fresh.contact[0].count);
  CHECK(physics.stateHash() == stateHash(model, fresh));
  const RunSummary again = run(physics, model, pressing(40));
  CHECK(again.state_hash == first.state_hash);
  CHECK(again.peak_force == first.peak_force);
}

TEST_CASE("A live session on tissue is repeated by its recording", "[tissue_physics]") {
  constexpr int ticks = 80;
  Recording recording;
  std::uint64_t hash = 0;
  {
    const Model& model = block();
    recording.model_hash = modelHash(model);
    recording.rate_hz = model.scene.dynamics.rate_hz;
    TissuePhysics physics(model, 1);
    SimulationLoopOptions options;
    options.tick_limit = ticks;
    options.record = true;
    SimulationLoop loop(model, physics, &physics.team(), options);
    Pose pressed = model.tools.first().start.pose;
    pressed.position.z() -= 0.004;
    const Material soft = stiffened(model.materials[0], 0.5);
    test::FakeClock clock;
    clock.before_sleep = [&](int sleep) {
      if (sleep == 2) loop.commands().push(Request::moveTool(pressed));
      if (sleep == 30) loop.commands().push(Request::setFriction(0));
      if (sleep == 40) loop.commands().push(Request::setMaterial(0, soft));
      if (sleep == 50) loop.commands().push(Request::pull(0, Vec3(0, 0, 0.05)));
      if (sleep == 60) loop.commands().push(Request::simple(Request::Kind::ReleasePull));
      if (sleep == ticks) loop.commands().push(Request::setFriction(0.6));  // after the last tick
    };
    loop.run(clock);
    TimedRequest change;
    while (loop.recorded().pop(change)) recording.changes.push_back(change);
    recording.ticks = loop.summary().ticks;
    hash = loop.summary().state_hash;
    CHECK(physics.state().live.friction[0] == 0.6);
    CHECK(physics.state().live.kernel.materials[0].shear_modulus == soft.shear_modulus);
  }
  const Model& model = block();
  checkRecordingFits(recording, model, "recording");
  TissuePhysics physics(model, 2);
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  options.tick_limit = options.track_ticks = recording.ticks;
  options.track = recording.changes;
  SimulationLoop loop(model, physics, &physics.team(), options);
  test::FakeClock clock;
  loop.run(clock);
  CHECK(loop.summary().state_hash == hash);
}

TEST_CASE("A material too stiff for the time step is refused, a softer one gives way", "[tissue_physics]") {
  double force[2];
  for (const int soft : {0, 1}) {
    const Model& model = block();
    TissuePhysics physics(model, 1);
    Material material = model.materials[0];
    const double stiff_bulk = material.bulk_modulus;
    material.bulk_modulus = 10 * stiff_bulk;
    CHECK(physics.setMaterial(0, material) > 1);
    CHECK(physics.state().live.kernel.materials[0].bulk_modulus == stiff_bulk);
    if (soft == 1) {
      material = model.materials[0];
      material = stiffened(material, 0.25);
      CHECK(physics.setMaterial(0, material) == 0);
    }
    force[soft] = run(physics, model, pressing(60)).peak_force;
  }
  CHECK(force[1] < 0.6 * force[0]);
}

TEST_CASE("Two simulations share a model, and what is set live in one leaves the other as it was", "[tissue_physics]") {
  const Model& model = block();
  const std::uint64_t as_loaded = modelHash(model);
  constexpr int ticks = 60;
  TissuePhysics alone(model, 1);
  const RunSummary expected = run(alone, model, pressing(ticks));
  const Material stiff = stiffened(model.materials[0], 1.2);

  for (const bool at_once : {false, true}) {
    TissuePhysics changed(model, 1), untouched(model, 1);
    const auto change = [&] {
      REQUIRE(changed.setMaterial(0, stiff) == 0);
      changed.setFriction(0, 0);
    };
    RunSummary of_changed, of_untouched;
    if (at_once) {  // each on a thread of its own, the change in the middle
      SimulationLoopOptions options = pressing(ticks);
      // No stable_sort: its buffer (gcc 12) is not aligned as a request's pose asks for.
      const auto middle = std::find_if(options.track.begin(), options.track.end(),
                                       [](const TimedRequest& r) { return r.tick > ticks / 2; });
      options.track.insert(middle, {{ticks / 2, Request::setMaterial(0, stiff)}, {ticks / 2, Request::setFriction(0)}});
      SimulationLoop first(model, changed, nullptr, options), second(model, untouched, nullptr, pressing(ticks));
      first.start();
      second.start();
      first.join();
      second.join();
      of_changed = first.summary();
      of_untouched = second.summary();
    } else {
      change();
      of_changed = run(changed, model, pressing(ticks));
      of_untouched = run(untouched, model, pressing(ticks));
    }
    CHECK(changed.state().live.friction[0] == 0);
    CHECK(untouched.state().live.friction[0] == model.scene.tools[0].friction);
    CHECK(of_changed.state_hash != expected.state_hash);
    CHECK(of_changed.peak_force > 1.05 * expected.peak_force);
    CHECK(of_untouched.state_hash == expected.state_hash);
    CHECK(of_untouched.peak_force == expected.peak_force);
    CHECK(sameBits(untouched.state().u, alone.state().u));
  }
  CHECK(modelHash(model) == as_loaded);
}

TEST_CASE("A reset keeps what was set live", "[tissue_physics]") {
  const Model& model = block();
  TissuePhysics physics(model, 1);
  Material soft = model.materials[0];
  soft.shear_modulus *= 0.5;
  physics.setFriction(0, 0.7);
  CHECK(physics.setMaterial(0, soft) == 0);
  physics.reset();
  CHECK(physics.state().live.friction[0] == 0.7);
  CHECK(physics.state().live.kernel.materials[0].shear_modulus == soft.shear_modulus);
}

TEST_CASE("Ticks of tissue neither allocate nor lock, on any thread of the team", "[tissue_physics]") {
  if (!test::guardAvailable()) return;  // under a sanitizer; the release preset has it
  for (const int threads : {1, 2, 3}) {
    const Model& model = block();
    TissuePhysics physics(model, threads);
    SimulationLoopOptions options = pressing(60, false);
    options.record = true;
    options.track.push_back({60, Request::simple(Request::Kind::Reset)});
    options.track.push_back({61, Request::pull(0, Vec3(0, 0, 0.04))});
    options.tick_limit = 80;
    SimulationLoop loop(model, physics, &physics.team(), options);
    test::FakeClock clock;
    std::vector<test::GuardCounts> counts(static_cast<std::size_t>(threads));
    test::startGuard(physics.team());
    loop.run(clock);
    test::stopGuard(physics.team(), counts);
    for (std::size_t member = 0; member < counts.size(); ++member) {
      INFO("member " << member << " of " << threads);
      CHECK(counts[member].allocations == 0);
      CHECK(counts[member].frees == 0);
      CHECK(counts[member].locks == 0);
    }
    CHECK(loop.summary().peak_force > 0.05);
  }
}

TEST_CASE("Ticks of tissue make no system call but the sleep and looks at the thread's own use of the processor",
          "[tissue_physics]") {
  if (!test::guardAvailable()) return;
  constexpr int all_done = 17;
  const int code = test::exitCodeOfChild([] {
    // Never destroyed: giving their memory back would be a system call of this process, not of the ticks.
    auto& model = *new Model(block());
    auto& physics = *new TissuePhysics(model, 1);
    auto& loop = *new SimulationLoop(model, physics, nullptr, pressing(60, false));
    test::ClockWithStart clock(test::allowOnlySleeping);
    loop.run(clock);
    return loop.summary().peak_force > 0.05 ? all_done : 1;
  });
  if (code == test::kNoFilter) {
    WARN("seccomp is not permitted here: system calls are not checked");
    return;
  }
  INFO("100 + number of a system call, mod 100, if above 99");
  CHECK(code == all_done);
}

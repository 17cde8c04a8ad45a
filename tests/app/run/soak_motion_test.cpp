#include "app/run/soak_motion.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::app;

namespace {

const std::vector<SoakPlace> kPlaces = {{{0, 0}, 0.002, 0.006}, {{0.01, -0.01}, 0.002, 0.005}};

std::vector<SoakCycle> drain(SpscRing<SoakCycle>& ring) {
  std::vector<SoakCycle> all;
  for (SoakCycle cycle; ring.pop(cycle);) all.push_back(cycle);
  return all;
}

SimulationLoopOptions driven(ToolMotion& motion, std::int64_t ticks) {
  SimulationLoopOptions options;
  options.motion = &motion;
  options.tick_limit = ticks;
  return options;
}

}  // namespace

TEST_CASE("Cycles on tissue press, drag, lift off and end at the same rest", "[soak_motion][whole]") {
  const Scene scene = test::blockScene(0.015);
  const std::int64_t ticks = std::llround(20 * scene.dynamics.rate_hz);
  std::uint64_t hash[2];
  for (std::uint64_t& h : hash) {
    Model model = test::blockModel(scene);
    TissuePhysics physics(model, 1);
    SoakMotion motion(model, kPlaces, 3);
    SimulationLoop loop(model, physics, nullptr, driven(motion, ticks));
    test::FakeClock clock;
    Vec3 last = model.tools.first().start.pose.position;
    double fastest = 0, lowest = 1, sideways = 0;
    clock.before_sleep = [&](int sleep) {
      const Vec3 now = physics.state().tool[0].pose.position;
      fastest = std::max(fastest, (now - last).norm() * scene.dynamics.rate_hz);
      lowest = std::min(lowest, now.z());
      sideways = std::max(sideways, now.head<2>().norm());
      last = now;
      // A viewer's moves count for nothing.
      if (sleep == 100) loop.commands().push(Request::moveTool(Pose{}));
    };
    loop.run(clock);
    h = loop.summary().state_hash;
    CHECK(fastest > 0.1);
    CHECK(fastest < 1.875 * 0.2 * 1.001);  // m/s: the quickest leg's mean, and what its smooth start and stop add
    CHECK(lowest < 0.03 - 0.3 * 0.005);
    CHECK(lowest > 0.03 - 0.006 - 1e-9);
    CHECK(sideways > 0.012);
    CHECK(sideways < std::hypot(0.01, 0.01) + 0.6 * 0.01);

    const std::vector<SoakCycle> cycles = drain(motion.cycles());
    REQUIRE(cycles.size() >= 4);
    CHECK(cycles[0].drift_m == 0);
    for (std::size_t k = 0; k < cycles.size(); ++k) {
      INFO("cycle " << k << ", rest of " << cycles[k].rest_s << " s, drift " << cycles[k].drift_m << " m");
      CHECK(cycles[k].number == static_cast<std::int64_t>(k) + 1);
      CHECK(cycles[k].rested);
      CHECK(cycles[k].rest_speed <= motion.rest().restSpeed());
      CHECK(cycles[k].rest_s > RestWatch::rest_hold_s);
      CHECK(cycles[k].drift_m < RestWatch::drift_limit * motion.rest().organSize());
      CHECK(cycles[k].peak_force_N > 0.02);
      CHECK(cycles[k].min_J < 0.999F);
      CHECK(cycles[k].depth_m >= 0.3 * 0.005);
      CHECK(cycles[k].depth_m <= 0.006);
    }
    CHECK(cycles[0].depth_m != cycles[1].depth_m);
  }
  CHECK(hash[0] == hash[1]);
}

TEST_CASE("A rest that is not the first one's is told as drift, tissue that never rests as that", "[soak_motion]") {
  const Model model = test::smallModel();
  for (const bool moving : {false, true}) {
    test::FakePhysics physics(model);
    physics.on_tick = [moving](State& state, StepReport& report) {
      for (Float4& u : state.u) u = {};
      state.u[2].y = 1e-6F * static_cast<float>(state.tick);
      report.max_increment = moving ? 1e-3F : 0;
    };
    SoakMotion motion(model, kPlaces, 1);
    SimulationLoop loop(model, physics, nullptr, driven(motion, 40'000));
    test::FakeClock clock;
    loop.run(clock);
    const std::vector<SoakCycle> cycles = drain(motion.cycles());
    REQUIRE(cycles.size() >= 2);
    CHECK(cycles[1].rested != moving);
    CHECK(cycles[1].rest_s == Approx(moving ? RestWatch::longest_rest_s : RestWatch::rest_hold_s).margin(0.003));
    const auto ticks = static_cast<double>(cycles[1].end_tick - cycles[0].end_tick);
    CHECK(cycles[1].drift_m == Approx(1e-6 * ticks).epsilon(1e-4));
  }
}

TEST_CASE("Tissue that trembles with its coordinates' rounding and goes nowhere is at rest", "[soak_motion]") {
  const Model model = test::smallModel();
  const RestWatch rest(model);
  for (const bool within : {true, false}) {
    test::FakePhysics physics(model);
    physics.on_tick = [&](State& state, StepReport& report) {
      for (Float4& u : state.u) u = {};
      // To and fro, over somewhat less or more than the radius.
      state.u[1].x = static_cast<float>((within ? 0.9 : 1.1) * rest.restRadius() * static_cast<double>(state.tick % 2));
      report.max_increment = state.u[1].x;
    };
    SoakMotion motion(model, kPlaces, 1);
    SimulationLoop loop(model, physics, nullptr, driven(motion, 20'000));
    test::FakeClock clock;
    loop.run(clock);
    const std::vector<SoakCycle> cycles = drain(motion.cycles());
    REQUIRE_FALSE(cycles.empty());
    CHECK(cycles[0].rested == within);
    CHECK(cycles[0].rest_s == Approx(within ? RestWatch::rest_hold_s : RestWatch::longest_rest_s).margin(0.003));
  }
}

TEST_CASE("Where a further tool holds the tissue, no drift is told", "[soak_motion]") {
  const Model model = test::smallModel();
  RestWatch rest(model);
  State state;
  state.u.resize(model.X.size());
  StepReport report;
  report.loads[1].contact_count = 3;
  rest.update(state, report);
  CHECK(rest.driftOf(state) == 0);
  state.u[0].x = 1e-3F;
  rest.update(state, report);
  CHECK(rest.driftOf(state) == 0);
  report.loads[1].contact_count = 0;
  rest.update(state, report);
  CHECK(rest.driftOf(state) == 0);  // the first rest
  state.u[0].x = 3e-3F;
  rest.update(state, report);
  CHECK(rest.driftOf(state) == Approx(2e-3));
}

TEST_CASE("What a further tool held still comes to rest anew when that lets go", "[soak_motion]") {
  const Model model = test::smallModel();
  RestWatch rest(model);
  State state;
  state.u.resize(model.X.size());
  const auto ticksToRest = [&](int contacts) {
    StepReport report;
    report.loads[1].contact_count = contacts;
    int ticks = 1;
    while (!rest.update(state, report)) ++ticks;
    return ticks;
  };
  const int hold = ticksToRest(3);
  CHECK(hold == Approx(RestWatch::rest_hold_s * model.scene.dynamics.rate_hz).margin(1));
  CHECK(ticksToRest(3) == 1);
  CHECK(ticksToRest(0) == hold);
  CHECK(ticksToRest(0) == 1);
}

TEST_CASE("Where a body may slide, its drift is told without the slide", "[soak_motion]") {
  Model model = test::smallModel();
  model.imposed = {4, 4, 4, 4};  // on ice
  RestWatch rest(model);
  State state;
  state.u.resize(model.X.size());
  rest.update(state, {});
  REQUIRE(rest.driftOf(state) == 0);
  for (Float4& u : state.u) u = {0.01F, -0.02F, 0, 0};
  CHECK(rest.driftOf(state) < 1e-15);
  for (Float4& u : state.u) u.z = 1e-3F;  // not a slide
  CHECK(rest.driftOf(state) == Approx(1e-3));
  for (Float4& u : state.u) u.z = 0;
  state.u[0].x += 1e-3F;
  CHECK(rest.driftOf(state) == Approx(0.75e-3).epsilon(1e-4));  // of four nodes
  CHECK(rest.slidOf(state).isApprox(Vec3(0.01025, -0.02, 0), 1e-5));
  Model loose = model;
  loose.imposed.assign(4, 0);
  loose.scene.rigid.emplace_back();
  RestWatch on_table(loose);
  CHECK(on_table.driftOf(State(state)) == 0);
  State elsewhere = state;
  for (Float4& u : elsewhere.u) u.z += 0.01F;
  CHECK(on_table.driftOf(elsewhere) == 0);  // it may rest anywhere
  // Far off, the coordinates' last bit is larger than what the bound on the speed allows; here too it is at rest.
  const float far = 0.2F;
  for (const bool on_ice : {true, false}) {
    if (!on_ice) model.imposed[0] = 7;
    RestWatch watch(model);
    watch.begin();
    StepReport trembles;
    trembles.max_increment = 1;
    bool over = false;
    for (int t = 0; t < 100 && !over; ++t) {
      for (Float4& u : state.u) u = {t % 2 == 0 ? far : std::nextafter(far, 1.0F), 0, 0, 0};
      over = watch.update(state, trembles);
    }
    CHECK(std::nextafter(far, 1.0F) - far > watch.restRadius());
    CHECK(watch.rested() == on_ice);
  }
}

TEST_CASE("After a reset the cycles begin again", "[soak_motion]") {
  const Model model = test::smallModel();
  test::FakePhysics physics(model);
  SoakMotion motion(model, kPlaces, 1);
  SimulationLoop loop(model, physics, nullptr, driven(motion, 700));
  test::FakeClock clock;
  std::vector<Vec3> way;
  clock.before_sleep = [&](int sleep) {
    if (sleep > 0) way.push_back(loop.snapshots().latest().toolPose().position);
    if (sleep == 350) loop.commands().push(Request::simple(Request::Kind::Reset));
  };
  loop.run(clock);
  for (std::size_t k = 0; k < 349; ++k) REQUIRE(way[k] == way[350 + k]);
  CHECK(way[100] != way[200]);
}

TEST_CASE("The soak's motion neither allocates nor locks", "[soak_motion]") {
  if (!test::guardAvailable()) return;
  const Model model = test::smallModel();
  test::FakePhysics physics(model);
  physics.on_tick = [](State&, StepReport& report) { report.max_increment = 0; };
  SoakMotion motion(model, kPlaces, 1);
  SimulationLoop loop(model, physics, nullptr, driven(motion, 5000));
  test::FakeClock clock;
  test::startGuard();
  loop.run(clock);
  const test::GuardCounts counts = test::stopGuard();
  CHECK(counts.total() == 0);
  CHECK(motion.cycles().size() >= 2);
}

#include "realtime/loop/fold_watch.h"

#include <catch2/catch.hpp>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "step/trust.h"

using namespace palpate;

namespace {

Model watched() {
  Model model = test::smallModel(500);
  model.rest_energy = 1e-6;
  return model;
}

/// Nothing touches, nothing moves, and a point is crushed.
StepReport folded() {
  StepReport report;
  report.strain_energy = 1e-3;
  report.min_J = TrustLimits::min_J - 0.01F;
  return report;
}

/// The ticks after which `watch` finds a fold; -1: not within `most`.
int ticksUntilFound(FoldWatch& watch, const StepReport& report, bool pulled = false, int most = 5000,
                    double seconds = 10) {
  for (int t = 1; t <= most; ++t)
    if (watch.update(report, pulled, seconds)) return t;
  return -1;
}

}  // namespace

TEST_CASE("Tissue that stands still strained, and nothing touches it, has folded", "[fold_watch]") {
  const Model model = watched();
  FoldWatch watch(model);
  CHECK(ticksUntilFound(watch, folded()) == 250);
  CHECK(ticksUntilFound(watch, folded()) == 250);  // and anew
  StepReport strained = folded();
  strained.min_J = 0.9F;
  CHECK(ticksUntilFound(watch, strained) == 250);
  strained.strain_energy = 0.9 * FoldWatch::strained * model.rest_energy;
  CHECK(ticksUntilFound(watch, strained) == -1);
  StepReport crushed = folded();  // a single point in a large body
  crushed.strain_energy = 0.1 * model.rest_energy;
  CHECK(ticksUntilFound(watch, crushed) == 250);
}

TEST_CASE("Tissue that is touched, pulled, moved or on its way has not folded", "[fold_watch]") {
  Model model = watched();
  FoldWatch watch(model);
  CHECK(ticksUntilFound(watch, folded(), true) == -1);
  StepReport touched = folded();
  touched.contact_count = 1;
  CHECK(ticksUntilFound(watch, touched) == -1);
  StepReport swinging = folded();
  swinging.min_J = 0.9F;
  swinging.kinetic_energy = 0.01 * swinging.strain_energy;
  CHECK(ticksUntilFound(watch, swinging) == -1);
  // Creeping back: half of the energy in each ten seconds.
  StepReport creeping = folded();
  for (int t = 0; t < 5000; ++t) {
    creeping.strain_energy *= 1 - 0.693 / 5000;
    REQUIRE_FALSE(watch.update(creeping, false, 10));
  }
  // A touch in between begins the time anew.
  for (int t = 0; t < 5000; ++t) REQUIRE_FALSE(watch.update(t % 200 == 0 ? touched : folded(), false, 10));
  Model moved = watched();
  moved.scene.boundaries.emplace_back();
  moved.scene.boundaries.back().duration = 1;
  FoldWatch of_moved(moved);
  CHECK(ticksUntilFound(of_moved, folded()) == -1);  // it may be how this body rests
  model.materials.front().relaxation_count = 1;      // comes back slowly: only what is crushed counts
  FoldWatch relaxing(model);
  StepReport strained = folded();
  strained.min_J = 0.9F;
  CHECK(ticksUntilFound(relaxing, strained) == -1);
  CHECK(ticksUntilFound(relaxing, folded()) == 250);
}

TEST_CASE("Tissue that stays crushed has folded, even where it swings", "[fold_watch]") {
  const Model model = watched();
  FoldWatch watch(model);
  StepReport swinging = folded();
  swinging.kinetic_energy = 0.5 * swinging.strain_energy;
  CHECK(ticksUntilFound(watch, swinging) == 1500);
  CHECK(ticksUntilFound(watch, swinging) == 1500);  // and anew
  CHECK(ticksUntilFound(watch, swinging, true) == -1);
  // It loses much of its energy for two seconds, and then no more.
  int ticks = 0;
  for (bool found = false; !found; ++ticks) {
    if (ticks < 1000) swinging.strain_energy *= 0.9995;
    REQUIRE(ticks < 5000);
    found = watch.update(swinging, false, 10);
  }
  CHECK(ticks > 1500);
  CHECK(ticks < 2500);
  // Not crushed for a tick: it begins anew.
  StepReport open = swinging;
  open.min_J = 0.9F;
  for (int t = 0; t < 5000; ++t) REQUIRE_FALSE(watch.update(t % 1400 == 0 ? open : swinging, false, 10));
}

TEST_CASE("A body whose boundaries were moved has folded where a point is far smaller than at a rest before",
          "[fold_watch]") {
  Model moved = watched();
  moved.scene.boundaries.resize(2);
  moved.scene.boundaries[0].duration = 1;
  moved.scene.boundaries[1].duration = 1;
  moved.scene.boundaries[1].curve.time = {0, 2, 3};
  FoldWatch watch(moved);
  StepReport rest = folded(), pressed = folded();
  rest.min_J = 0.9F;
  pressed.min_J = 0.2F;
  // While they move, nothing is learnt.
  StepReport begin = rest;
  begin.min_J = 1;
  REQUIRE(ticksUntilFound(watch, begin, false, 500, 2.9) == -1);
  CHECK(ticksUntilFound(watch, pressed, false, 500, 3.1) == -1);
  CHECK(watch.memory().rest_J == Approx(0.2));
  // Nor while it swings, or is touched.
  StepReport swinging = rest;
  swinging.kinetic_energy = 0.01 * swinging.strain_energy;
  REQUIRE(ticksUntilFound(watch, swinging, false, 500) == -1);
  CHECK(watch.memory().rest_J == Approx(0.2));
  REQUIRE(ticksUntilFound(watch, rest, false, 500) == -1);
  CHECK(watch.memory().rest_J == Approx(0.9));
  StepReport less = rest;
  less.min_J = static_cast<float>(0.9 * FoldWatch::smaller) + 0.01F;
  CHECK(ticksUntilFound(watch, less, false, 500) == -1);
  CHECK(ticksUntilFound(watch, pressed, false, 500) == 250);
  // Once: if that is how it rests with materials that were changed since, it stays so.
  CHECK(ticksUntilFound(watch, pressed, false, 500) == -1);
}

TEST_CASE("Folded tissue is put back to rest, counted and told of", "[fold_watch]") {
  const Model model = watched();
  test::FakePhysics physics(model);
  physics.on_tick = [](State& state, StepReport& report) {
    if (state.tick < 100) return;
    report = folded();
    state.u[0].x = 0.05F;
  };
  SimulationLoopOptions options;
  options.tick_limit = 400;
  SimulationLoop loop(model, physics, nullptr, options);
  test::FakeClock clock;
  loop.run(clock);
  CHECK(loop.summary().restored_count == 1);
  CHECK_FALSE(loop.summary().frozen);
  int told = 0;
  LogEvent event;
  while (loop.log().pop(event)) told += event.kind == LogEvent::Kind::RestoredFolded && event.isRestore();
  CHECK(told == 1);
  CHECK(physics.state().u[0].x != 0.05F);
}

TEST_CASE("A run recalled from a folded state, too, comes back to rest", "[fold_watch]") {
  const Model model = watched();
  test::FakePhysics physics(model);
  const float rest = physics.state().u[0].x;
  physics.on_tick = [](State& state, StepReport& report) {
    if (state.tick > 0 && state.u[0].y != 0) report = folded();
  };
  SimulationLoop loop(model, physics, nullptr, {});
  loop.advanceHere(100);
  loop.recall(loop.memory());
  loop.advanceHere(149);
  CHECK(physics.state().tick == 249);
  loop.advanceHere(1);
  // Put back to the state at rest, not to that of the recall, which was folded.
  CHECK(physics.state().tick < 100);
  CHECK(physics.state().u[0].x == rest);
}

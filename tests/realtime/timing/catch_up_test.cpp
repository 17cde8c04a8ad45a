#include "realtime/timing/catch_up.h"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr std::int64_t kStallMs = 1'000'000;  // ns

/// A run of the loop on a computer that now and then does something else for 5 to 15 ms.
struct StalledRun {
  double realtime_factor = 0;
  std::int64_t overruns = 0, caught_up = 0, wakeups = 0;
  std::uint64_t hash = 0;
  std::vector<std::int64_t> begins;  // ns since the start
};

StalledRun stalledRun(int catch_up, double stalls_per_tick, std::int64_t tick_ns = 8 * kStallMs / 10,
                      int ticks = 10'000) {
  Model model = smallModel(500);
  model.scene.dynamics.catch_up = catch_up;
  FakePhysics physics(model);
  FakeClock clock;
  const std::int64_t start = clock.time;
  StalledRun run;
  std::mt19937 random(3);
  physics.on_tick = [&](State&, StepReport&) {
    run.begins.push_back(clock.time - start);
    clock.time += tick_ns;
    const bool stalls = random() < stalls_per_tick * 4294967296.0;
    const auto stall = static_cast<std::int64_t>(random() % (10 * kStallMs)) + 5 * kStallMs;
    if (stalls) clock.time += stall;
  };
  SimulationLoopOptions options = limited(ticks);
  options.track = trackFromPoses(wander(ticks, 1));
  SimulationLoop loop(model, physics, nullptr, options);
  loop.run(clock);
  const DeadlineStatistics& statistics = loop.statistics();
  run.realtime_factor = loop.summary().totals.realtime_factor;
  run.overruns = statistics.overrun_count;
  run.caught_up = statistics.caught_up_count;
  run.wakeups = statistics.wakeup_late.count();
  run.hash = loop.summary().state_hash;
  CHECK(loop.summary().ticks == ticks);
  // What was missed was made good or skipped; what is owed at the end is neither.
  const double periods = ticks + static_cast<double>(run.overruns - run.caught_up);
  CHECK(std::abs(loop.summary().totals.wall_seconds * 500 - periods) < 1e-6);
  return run;
}

}  // namespace

TEST_CASE("Where stalls of 5 to 15 ms cost a tenth of real time, catching up wins it back, tick for tick",
          "[catch_up]") {
  const StalledRun skipping = stalledRun(0, 0.025), little = stalledRun(4, 0.025), usual = stalledRun(16, 0.025);
  CHECK(skipping.realtime_factor == Approx(0.89).margin(0.01));
  CHECK(skipping.caught_up == 0);
  CHECK(little.realtime_factor > skipping.realtime_factor + 0.05);
  CHECK(usual.realtime_factor >= 0.999);
  CHECK(usual.caught_up > 1000);
  CHECK(usual.wakeups == 10'000 - usual.caught_up);
  CHECK(usual.hash == skipping.hash);
  CHECK(little.hash == skipping.hash);
}

TEST_CASE("After a stall the late ticks follow at once until the grid is reached, and the phase is kept",
          "[catch_up]") {
  Model model = smallModel(500);
  model.scene.dynamics.catch_up = 8;
  FakePhysics physics(model);
  FakeClock clock;
  const std::int64_t start = clock.time;
  std::vector<std::int64_t> begins;
  physics.on_tick = [&](State& state, StepReport&) {
    begins.push_back(clock.time - start);
    clock.time += state.tick == 11 ? 91 * kStallMs / 10 : kStallMs / 2;  // tick 10, from 20 ms to 29.1 ms
  };
  SimulationLoop loop(model, physics, nullptr, limited(40));
  loop.run(clock);
  // Grid times 22, 24, 26, 28 were missed; the tick of 30 begins when the four are made good at 31.1, late by 1.1.
  for (std::size_t k = 11; k <= 15; ++k)
    CHECK(begins[k] == 291 * kStallMs / 10 + static_cast<int>(k - 11) * kStallMs / 2);
  for (std::size_t k = 16; k < 40; ++k) CHECK(begins[k] == static_cast<int>(k) * 2 * kStallMs);
  CHECK(loop.statistics().overrun_count == 5);
  CHECK(loop.statistics().caught_up_count == 5);
  CHECK(loop.statistics().longest_overrun_streak == 5);
  CHECK(loop.summary().totals.realtime_factor == 1.0);
  const std::vector<LogEvent> events = drain(loop.log());
  REQUIRE(events.size() == 1);  // of the tick that was late, not of those that followed at once
  CHECK(events[0].overload.worst.tick == 10);
  CHECK(events[0].overload.worst.missed == 4);
  CHECK(logText(events[0]).find("4 periods late, made good") != std::string::npos);
}

TEST_CASE("A stall longer than what is made good skips the rest, and says so", "[catch_up]") {
  CatchUp catch_up(4);
  CatchUp::Outcome lost = catch_up.tickEnded(10);
  CHECK(lost.missed == 10);
  CHECK(lost.skipped == 6);
  for (int behind = 3; behind >= 0; --behind) {
    CHECK(catch_up.owes());
    lost = catch_up.tickEnded(behind);
    CHECK(lost.missed == 0);
    CHECK(lost.skipped == 0);
  }
  CHECK_FALSE(catch_up.owes());
  CHECK(catch_up.streak() == 0);

  LateTick late;
  late.period_ns = 2 * kStallMs;
  late.step_ns = 21 * kStallMs;
  late.missed = 10;
  late.skipped = 6;
  CHECK(lateTickText(late).find("10 periods late, 6 skipped") != std::string::npos);
}

TEST_CASE("A computer too slow for the rate skips as without catching up, but for one spell", "[catch_up]") {
  const StalledRun skipping = stalledRun(0, 0, 3 * kStallMs), overloaded = stalledRun(16, 0, 3 * kStallMs);
  CHECK(skipping.realtime_factor == Approx(0.5).epsilon(1e-9));
  CHECK(overloaded.realtime_factor == Approx(0.5).epsilon(0.01));
  CHECK(overloaded.caught_up <= 16 * CatchUp::longest_spell);
  CHECK(overloaded.hash == skipping.hash);
  // Once it has given up it begins on the grid again.
  for (std::size_t k = 100; k < overloaded.begins.size(); ++k) REQUIRE(overloaded.begins[k] % (2 * kStallMs) == 0);
}

TEST_CASE("Nothing is owed after a pause", "[catch_up]") {
  CatchUp catch_up(8);
  catch_up.tickEnded(5);
  REQUIRE(catch_up.owes());
  catch_up.paused();
  CHECK_FALSE(catch_up.owes());
  CHECK(catch_up.tickEnded(0).missed == 0);
}

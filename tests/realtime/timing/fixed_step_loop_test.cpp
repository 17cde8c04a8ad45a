#include "realtime/timing/fixed_step_loop.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "realtime/fakes.h"

using namespace palpate;
using palpate::test::FakeClock;

namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

/// Each call takes cost(call) ns and does outcome(call); notes when it began.
class FakeBody final : public LoopBody {
 public:
  FakeBody(FakeClock& clock, int calls) : clock_(clock), calls_(calls) {}
  std::function<std::int64_t(int)> cost = [](int) { return kMs / 2; };
  std::function<TickOutcome(int)> outcome = [](int) { return TickOutcome::Advanced; };
  std::vector<std::int64_t> begins;
  std::vector<LoopTime> times;

  TickOutcome onTick(const LoopTime& time) override {
    const int call = static_cast<int>(begins.size());
    if (call == calls_) return TickOutcome::Stop;
    begins.push_back(clock_.time);
    times.push_back(time);
    clock_.time += cost(call) + wait;
    waited_ += wait;
    return outcome(call);
  }
  std::int64_t waited() const override { return waited_; }
  std::int64_t wait = 0;  // ns, of each call, for others

 private:
  FakeClock& clock_;
  int calls_;
  std::int64_t waited_ = 0;
};

FixedStepOptions at(double rate_hz) {
  FixedStepOptions options;
  options.rate_hz = rate_hz;
  return options;
}

}  // namespace

TEST_CASE("Ticks in time begin on the grid, and time is real time", "[fixed_step_loop]") {
  FakeClock clock;
  const std::int64_t start = clock.time;
  FakeBody body(clock, 100);
  DeadlineStatistics statistics;
  const LoopTotals totals = runFixedStepLoop(at(500), clock, body, statistics);
  for (std::size_t k = 0; k < 100; ++k) REQUIRE(body.begins[k] == start + static_cast<std::int64_t>(k) * 2 * kMs);
  CHECK(statistics.ticks == 100);
  CHECK(statistics.overrun_count == 0);
  CHECK(statistics.longest_overrun_streak == 0);
  CHECK(statistics.step.percentileUs(0.5) == Approx(500).epsilon(0.008));
  CHECK(statistics.wakeup_late.maxUs() == 0);
  CHECK(totals.simulated_seconds == Approx(0.2).epsilon(1e-12));
  CHECK(totals.realtime_factor == 1.0);
}

TEST_CASE("A long tick loses whole periods and keeps the phase", "[fixed_step_loop]") {
  FakeClock clock;
  const std::int64_t start = clock.time;
  FakeBody body(clock, 20);
  body.cost = [](int call) { return call == 10 ? 51 * kMs / 10 : kMs / 2; };  // 2.55 periods
  DeadlineStatistics statistics;
  const LoopTotals totals = runFixedStepLoop(at(500), clock, body, statistics);
  CHECK(body.begins[10] == start + 10 * 2 * kMs);
  CHECK(body.begins[11] == start + 13 * 2 * kMs);  // grid times 11 and 12 were missed
  CHECK(body.begins[19] == start + 21 * 2 * kMs);
  CHECK(statistics.ticks == 20);
  CHECK(statistics.overrun_count == 2);
  CHECK(statistics.longest_overrun_streak == 2);
  CHECK(statistics.step.maxUs() == 5100);
  CHECK(totals.realtime_factor == Approx(20.0 / 22).epsilon(1e-12));  // ticks / (ticks + missed)
}

TEST_CASE("A tick done exactly at the next deadline is in time", "[fixed_step_loop]") {
  FakeClock clock;
  FakeBody body(clock, 10);
  body.cost = [](int) { return 2 * kMs; };
  DeadlineStatistics statistics;
  runFixedStepLoop(at(500), clock, body, statistics);
  CHECK(statistics.overrun_count == 0);

  FakeBody slower(clock, 10);
  slower.cost = [](int) { return 2 * kMs + 1; };  // a nanosecond more: every second period is lost
  DeadlineStatistics late;
  const LoopTotals totals = runFixedStepLoop(at(500), clock, slower, late);
  CHECK(late.overrun_count == 10);
  CHECK(late.longest_overrun_streak == 10);
  CHECK(totals.realtime_factor == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("A streak of missed deadlines ends with a tick in time", "[fixed_step_loop]") {
  FakeClock clock;
  FakeBody body(clock, 40);
  body.cost = [](int call) {
    if (call >= 5 && call < 8) return 3 * kMs;  // 1 missed each: streak 3
    if (call == 20) return 11 * kMs;            // 5 missed at once
    return kMs;
  };
  DeadlineStatistics statistics;
  runFixedStepLoop(at(500), clock, body, statistics);
  CHECK(statistics.overrun_count == 8);
  CHECK(statistics.longest_overrun_streak == 5);
}

TEST_CASE("Periods that are no whole number of nanoseconds don't drift", "[fixed_step_loop]") {
  FakeClock clock;
  const std::int64_t start = clock.time;
  constexpr int ticks = 100'000;
  FakeBody body(clock, ticks);
  DeadlineStatistics statistics;
  runFixedStepLoop(at(700), clock, body, statistics);
  CHECK(statistics.overrun_count == 0);
  CHECK(body.begins.back() == start + std::llround((ticks - 1) * 1e9 / 700));
}

TEST_CASE("Late wake-ups are measured against the deadline", "[fixed_step_loop]") {
  FakeClock clock;
  clock.late = 120'000;
  FakeBody body(clock, 50);
  DeadlineStatistics statistics;
  runFixedStepLoop(at(1000), clock, body, statistics);
  CHECK(statistics.wakeup_late.percentileUs(0.5) == Approx(120).epsilon(0.008));
  CHECK(statistics.overrun_count == 0);  // 0.12 + 0.5 ms of a 1 ms period

  clock.late = 3'700'000;  // asleep over three more deadlines, and done after another
  FakeBody sleepy(clock, 10);
  DeadlineStatistics late;
  runFixedStepLoop(at(1000), clock, sleepy, late);
  CHECK(late.ticks == 10);
  // The first sleep ends at once. Each later tick: awake 3.7, done 4.2 periods after its deadline.
  CHECK(late.overrun_count == 9 * 4);
}

TEST_CASE("Pauses count neither as ticks nor as wall time nor as missed deadlines", "[fixed_step_loop]") {
  FakeClock clock;
  const std::int64_t start = clock.time;
  FakeBody body(clock, 300);
  body.outcome = [](int call) {
    return call >= 100 && call < 200 && call != 150 ? TickOutcome::Idle : TickOutcome::Advanced;
  };
  body.cost = [](int call) { return call == 120 ? 9 * kMs : kMs / 2; };  // slow, but paused
  DeadlineStatistics statistics;
  const LoopTotals totals = runFixedStepLoop(at(500), clock, body, statistics);
  CHECK(statistics.ticks == 201);
  CHECK(statistics.step.count() == 201);
  CHECK(statistics.overrun_count == 0);
  CHECK(totals.wall_seconds == Approx(201 * 0.002).epsilon(1e-12));
  CHECK(totals.realtime_factor == Approx(1.0).epsilon(1e-12));
  CHECK((body.begins.back() - start) % (2 * kMs) == 0);
}

TEST_CASE("The live realtime factor starts afresh after a pause - the recent one looks back a second",
          "[fixed_step_loop]") {
  FakeClock clock;
  FakeBody body(clock, 2000);
  body.cost = [](int call) { return call < 500 ? 3 * kMs : kMs; };  // half speed, then full
  body.outcome = [](int call) { return call == 1500 ? TickOutcome::Idle : TickOutcome::Advanced; };
  DeadlineStatistics statistics;
  runFixedStepLoop(at(500), clock, body, statistics);
  CHECK(body.times[400].realtime_factor == Approx(0.5));
  CHECK(body.times[400].recent_realtime_factor == Approx(0.5));
  CHECK(body.times[1499].realtime_factor == Approx(1499.0 / 1999));
  CHECK(body.times[1499].recent_realtime_factor == Approx(1.0));
  CHECK(body.times[1999].realtime_factor == Approx(1.0));
}

TEST_CASE("What a tick waits for others is no time of its step", "[fixed_step_loop]") {
  FakeClock clock;
  FakeBody body(clock, 100);
  body.wait = 300 * kMs;
  FixedStepOptions options = at(500);
  options.as_fast_as_possible = true;
  DeadlineStatistics statistics;
  const LoopTotals totals = runFixedStepLoop(options, clock, body, statistics);
  CHECK(statistics.step.maxUs() == Approx(500).epsilon(0.008));
  CHECK(totals.wall_seconds == Approx(100 * 0.3005));
}

TEST_CASE("As fast as possible never sleeps, and misses no deadlines, having none", "[fixed_step_loop]") {
  FakeClock clock;
  FakeBody body(clock, 1000);
  body.cost = [](int call) { return call % 2 == 0 ? kMs / 5 : 3 * kMs; };
  FixedStepOptions options = at(500);
  options.as_fast_as_possible = true;
  DeadlineStatistics statistics;
  const LoopTotals totals = runFixedStepLoop(options, clock, body, statistics);
  CHECK(clock.sleeps == 0);
  CHECK(statistics.overrun_count == 0);
  CHECK(statistics.wakeup_late.count() == 0);
  CHECK(totals.realtime_factor == Approx(2.0 / 1.6).epsilon(1e-12));
}

#include "realtime/timing/overload.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "realtime/loop/simulation_loop.h"
#include "realtime/loop_run.h"
#include "realtime/timing/overload_watch.h"

using namespace palpate;
using test::drain;
using test::FakeClock;
using test::FakePhysics;
using test::smallModel;

namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

LateTick late(std::int64_t late_ns, std::int64_t step_ns, std::int64_t computing_ns, std::int64_t long_waits = 0) {
  LateTick tick;
  tick.period_ns = 2 * kMs;
  tick.late_ns = late_ns;
  tick.step_ns = step_ns;
  tick.computing_ns = computing_ns;
  tick.long_waits = long_waits;
  tick.missed = 1;
  return tick;
}

}  // namespace

TEST_CASE("The cause of a late tick follows from its wall time, computing time and waits", "[overload]") {
  CHECK(causeOf(late(12 * kMs, kMs, kMs)) == LateCause::LateWakeUp);
  CHECK(causeOf(late(3 * kMs / 2, kMs, kMs)) == LateCause::LateWakeUp);  // would have fitted
  CHECK(causeOf(late(kMs / 20, 199 * kMs / 100, 198 * kMs / 100)) == LateCause::LongComputation);
  CHECK(causeOf(late(12 * kMs, 3 * kMs, 3 * kMs)) == LateCause::LateWakeUp);  // that cost the most
  CHECK(causeOf(late(0, 3 * kMs, 29 * kMs / 10)) == LateCause::LongComputation);
  CHECK(causeOf(late(0, 14 * kMs, kMs)) == LateCause::CoreTaken);
  CHECK(causeOf(late(0, 14 * kMs, kMs, 1)) == LateCause::WorkerLate);
  CHECK(causeOf(late(0, 14 * kMs, 13 * kMs, 1)) == LateCause::LongComputation);
}

TEST_CASE("Each late tick of a run is logged with tick and cause, and never stretches the step", "[overload]") {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  FakeClock clock;
  const std::int64_t start = clock.time;
  constexpr int spacing = 35'000;  // ticks: 70 s, so that each is told at once
  physics.on_tick = [&clock](State& state, StepReport&) {
    clock.time += kMs / 2;
    if (state.tick == 1 * spacing) clock.time += 26 * kMs / 10;  // computes for 3.1 ms
    if (state.tick == 2 * spacing) {                             // loses its core for 13.1 ms
      clock.time += 131 * kMs / 10;
      clock.away += 131 * kMs / 10;
      clock.use.involuntary_switches += 3;
    }
  };
  clock.before_sleep = [&clock](int sleep) { clock.late = sleep == 3 * spacing ? 123 * kMs / 10 : 0; };
  SimulationLoopOptions options;
  options.tick_limit = 4 * spacing;
  options.force_capacity = 1 << 18;
  SimulationLoop loop(model, physics, nullptr, options);
  loop.run(clock);

  std::vector<LogEvent> events;
  for (const LogEvent& event : drain(loop.log()))
    if (event.kind == LogEvent::Kind::TickLate) events.push_back(event);
  REQUIRE(events.size() == 3);
  const LateTick &computed = events[0].overload.worst, &taken = events[1].overload.worst,
                 &woken = events[2].overload.worst;
  CHECK(causeOf(computed) == LateCause::LongComputation);
  CHECK(computed.tick == spacing - 1);  // 0 is the first of the run
  CHECK(computed.computing_ns == 31 * kMs / 10);
  CHECK(computed.missed == 1);
  CHECK(causeOf(taken) == LateCause::CoreTaken);
  CHECK(taken.tick == 2 * spacing - 1);
  CHECK(taken.step_ns == 136 * kMs / 10);
  CHECK(taken.computing_ns == kMs / 2);
  CHECK(taken.involuntary_switches == 3);
  CHECK(taken.missed == 6);
  CHECK(causeOf(woken) == LateCause::LateWakeUp);
  CHECK(woken.late_ns == 123 * kMs / 10);
  CHECK(woken.missed == 6);
  CHECK(logText(events[0]).find("tick 34999 computed for 3.1 ms of a period of 2.0 ms: long computation") !=
        std::string::npos);
  CHECK(logText(events[1]).find("tick 69999 took 13.6 ms, 0.5 of them computing: its core was taken") !=
        std::string::npos);
  CHECK(logText(events[1]).find("3 involuntary switches") != std::string::npos);
  CHECK(logText(events[2]).find("was woken 12.3 ms late") != std::string::npos);
  CHECK(logText(events[2]).find("6 periods skipped") != std::string::npos);
  for (const LogEvent& event : events) CHECK(event.isWarning());
  const auto& by_cause = loop.statistics().late_ticks;
  CHECK(by_cause[0] == 1);
  CHECK(by_cause[1] == 1);
  CHECK(by_cause[2] == 0);
  CHECK(by_cause[3] == 1);

  // Simulated time counts ticks; wall time is ticks and skipped periods, all on the grid.
  CHECK(physics.calls == 4 * spacing);
  CHECK(loop.statistics().overrun_count == 13);
  const std::vector<ForceSample> samples = drain(loop.forces());
  REQUIRE(samples.size() == 4 * spacing);
  std::int64_t period = -1;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    REQUIRE(samples[k].tick == static_cast<std::int64_t>(k) + 1);
    REQUIRE(samples[k].time_s == static_cast<double>(k + 1) / 500.0);
    const std::int64_t offset = samples[k].wall_ns - start;
    if (samples[k].tick != woken.tick + 1) REQUIRE(offset % (2 * kMs) == 0);
    REQUIRE(offset / (2 * kMs) > period);
    period = offset / (2 * kMs);
  }
  CHECK(period + 1 == 4 * spacing + 13);
}

TEST_CASE("What a pause takes is not charged to the late tick after it", "[overload]") {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  FakeClock clock;
  constexpr int paused = 100;
  physics.on_tick = [&clock](State& state, StepReport&) {
    clock.time += state.tick == 11 ? 31 * kMs / 10 : kMs / 2;  // the first after the pause: 3.1 ms
  };
  SimulationLoopOptions options;
  options.tick_limit = 20;
  SimulationLoop loop(model, physics, nullptr, options);
  clock.before_sleep = [&](int sleep) {
    if (sleep == 10) loop.commands().push(Request::simple(Request::Kind::Pause));
    if (sleep == 10 + paused) loop.commands().push(Request::simple(Request::Kind::Resume));
    if (sleep <= 10 || sleep >= 10 + paused) return;
    clock.time += kMs / 10;  // CPU time and switches of a pause, before each sleep
    clock.use.involuntary_switches += 7;
    clock.use.page_faults += 5;
  };
  loop.run(clock);
  std::vector<LateTick> late_ticks;
  for (const LogEvent& event : drain(loop.log()))
    if (event.kind == LogEvent::Kind::TickLate) late_ticks.push_back(event.overload.worst);
  REQUIRE(late_ticks.size() == 1);
  CHECK(late_ticks[0].tick == 10);
  CHECK(late_ticks[0].step_ns == 31 * kMs / 10);
  // At most the last period of the pause: the loop looks when its body has returned.
  CHECK(late_ticks[0].computing_ns <= 32 * kMs / 10);
  CHECK(late_ticks[0].computing_ns >= 31 * kMs / 10);
  CHECK(late_ticks[0].involuntary_switches <= 7);
  CHECK(late_ticks[0].page_faults <= 5);
}

TEST_CASE("A lasting overload is told at its begin, summed up every minute and at its end", "[overload]") {
  const Model model = smallModel(500);
  FakePhysics physics(model);
  FakeClock clock;
  const std::int64_t start = clock.time;
  constexpr int bad = 70'000;  // ticks of 3 ms at two periods each: 280 s
  physics.on_tick = [&clock](State& state, StepReport&) { clock.time += state.tick <= bad ? 3 * kMs : kMs; };
  SimulationLoopOptions options;
  options.tick_limit = bad + 40'000;  // 80 s more
  SimulationLoop loop(model, physics, nullptr, options);
  double recent_in_overload = 0;
  clock.before_sleep = [&](int sleep) {
    if (sleep == bad) recent_in_overload = loop.snapshots().latest().status.recent_realtime_factor;
  };
  loop.run(clock);
  const std::vector<LogEvent> events = drain(loop.log());
  REQUIRE(events.size() == 6);
  CHECK(events[0].kind == LogEvent::Kind::TickLate);
  for (std::size_t k = 1; k <= 4; ++k) CHECK(events[k].kind == LogEvent::Kind::Overloaded);
  CHECK(events[5].kind == LogEvent::Kind::OverloadEnded);
  CHECK_FALSE(events[5].isWarning());
  const Overload& all = events[5].overload;
  CHECK(all.late_ticks == bad);
  CHECK(all.missed == bad);
  CHECK(all.by_cause[static_cast<std::size_t>(LateCause::LongComputation)] == bad);
  CHECK(all.first_tick == 0);
  CHECK(all.seconds == Approx(280.0).epsilon(1e-3));
  CHECK(logText(events[5]).find("on time again after 70000 late ticks in 280.0 s (70000 long computation), "
                                "70000 periods skipped") != std::string::npos);
  // Time slowed to half and came back by itself.
  CHECK(recent_in_overload == Approx(0.5).epsilon(1e-6));
  CHECK(loop.snapshots().latest().status.recent_realtime_factor == Approx(1.0).epsilon(1e-6));
  CHECK(static_cast<double>(clock.time - start) == Approx(2e6 * (2.0 * bad + 40'000)).epsilon(1e-4));
}

TEST_CASE("Many late ticks apart give at most two lines a minute, and each is counted", "[overload]") {
  OverloadWatch watch(500);
  LogRing log(4096);
  std::int64_t late_ticks = 0, tick = 0;
  for (; tick < 500 * 3600; ++tick) {  // an hour
    const std::int64_t now = tick * 2 * kMs;
    watch.update(now, tick, log);
    if (tick % 700 != 3) continue;  // every 1.4 s: each is quiet before the next
    LateTick one = late(0, 3 * kMs, 3 * kMs);
    one.tick = tick;
    watch.add(one, now, log);
    ++late_ticks;
  }
  watch.end(tick, log);
  const std::vector<LogEvent> events = drain(log);
  CHECK(events.size() > 30);
  CHECK(events.size() <= 120);
  std::int64_t told = 0, open = 0;  // a summary holds all of its overload, told before or not
  for (const LogEvent& event : events) {
    CHECK(event.overload.late_ticks > 0);
    open = event.overload.late_ticks;
    const bool last =
        event.kind == LogEvent::Kind::OverloadEnded || &event == &events.back() ||
        (event.kind == LogEvent::Kind::TickLate && (&event)[1].overload.first_tick != event.overload.first_tick);
    if (last) told += open;
  }
  CHECK(told == late_ticks);
}

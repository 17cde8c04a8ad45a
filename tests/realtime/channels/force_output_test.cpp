#include "realtime/channels/force_output.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"

using namespace palpate;

namespace {

/// A sample all of whose numbers tell its tick.
ForceSample marked(std::int64_t tick) {
  const auto t = static_cast<double>(tick);
  ForceSample sample;
  sample.tick = tick;
  sample.wall_ns = 1000 * tick;
  sample.time_s = 2 * t;
  sample.depth_m = 3 * t;
  sample.advance_m = -3 * t;
  sample.force_raw = {4 * t, 5 * t, 6 * t};
  sample.force_filtered = {7 * t, 8 * t, 9 * t};
  sample.doubt = static_cast<Doubt>(tick % 8);
  sample.tool_pose.position = {10 * t, 11 * t, 12 * t};
  sample.tool_pose.orientation = Quat(1 + 13 * t, 14 * t, 15 * t, 16 * t);
  sample.torque = {17 * t, 18 * t, 19 * t};
  sample.contact_normal = {20 * t, 21 * t, 22 * t};
  sample.stiffness = 23 * t;
  sample.work_J = 24 * t;
  sample.pose_sequence = static_cast<std::uint64_t>(25 * tick);
  sample.loss_count = 26 * tick;
  sample.contact_count = static_cast<int>(tick % 1000);
  sample.frozen = tick % 2 == 1;
  sample.node_count = static_cast<int>(tick % 5000);
  sample.place_late = tick % 3 == 1;
  for (std::size_t b = 0; b < sample.rigid_force.size(); ++b)
    sample.rigid_force[b] = {static_cast<float>(tick), static_cast<float>(b) * static_cast<float>(tick % 5),
                             static_cast<float>(tick % 7)};
  sample.expected_error = 27 * t;
  sample.error_force = 28 * t;
  sample.error_by = static_cast<int>(tick % 10) - 1;
  return sample;
}

bool isMarked(const ForceSample& s) {
  const ForceSample whole = marked(s.tick);
  return s.wall_ns == whole.wall_ns && s.time_s == whole.time_s && s.depth_m == whole.depth_m &&
         s.advance_m == whole.advance_m && s.force_raw == whole.force_raw && s.force_filtered == whole.force_filtered &&
         s.doubt == whole.doubt && s.tool_pose.position == whole.tool_pose.position &&
         s.tool_pose.orientation.coeffs() == whole.tool_pose.orientation.coeffs() && s.torque == whole.torque &&
         s.contact_normal == whole.contact_normal && s.stiffness == whole.stiffness && s.work_J == whole.work_J &&
         s.pose_sequence == whole.pose_sequence && s.loss_count == whole.loss_count &&
         s.contact_count == whole.contact_count && s.frozen == whole.frozen && s.node_count == whole.node_count &&
         s.place_late == whole.place_late && s.rigid_force == whole.rigid_force &&
         s.expected_error == whole.expected_error && s.error_force == whole.error_force && s.error_by == whole.error_by;
}

}  // namespace

TEST_CASE("A force is fresh for ten milliseconds or three periods, and not before there is one", "[force_output]") {
  constexpr std::int64_t begin = 5'000'000'000;  // ns
  for (const auto& [rate_hz, limit] : {std::pair{1000.0, 10'000'000}, {500.0, 10'000'000}, {100.0, 30'000'000}}) {
    ForceSample sample;
    sample.wall_ns = begin;
    CHECK_FALSE(readForce(sample, begin, rate_hz).fresh);  // tick 0: nothing was computed
    sample.tick = 1;
    CHECK(readForce(sample, begin, rate_hz).fresh);
    CHECK(readForce(sample, begin + limit - 1000, rate_hz).fresh);
    CHECK_FALSE(readForce(sample, begin + limit + 1000, rate_hz).fresh);
    CHECK(readForce(sample, begin + 2 * limit, rate_hz).age_s == Approx(2e-9 * limit).epsilon(1e-12));
    CHECK(readForce(sample, begin - 1, rate_hz).age_s == 0);
  }
}

TEST_CASE("While a loop keeps its deadlines its force is fresh at any time and rate", "[force_output]") {
  for (const double rate_hz : {20.0, 100.0, 250.0, 1000.0}) {
    const Model model = test::smallModel(rate_hz);
    test::FakePhysics physics(model);
    test::FakeClock clock;
    const std::int64_t start = clock.time;
    const auto period = static_cast<std::int64_t>(1e9 / rate_hz);
    std::int64_t reads = 0, stale = 0;
    const SimulationLoop* running = nullptr;
    const auto read = [&](std::int64_t now) {
      const ForceReading reading = readForce(running->force().sample, now, rate_hz);
      if (reading.sample.tick == 0) return;
      ++reads;
      stale += !reading.fresh;
    };
    // Every other tick takes nearly its whole period: the forces then grow as old as they can, on time.
    physics.on_tick = [&](State& state, StepReport&) {
      const std::int64_t cost = state.tick % 2 == 0 ? period * 99 / 100 : period / 100;
      for (int part = 0; part < 10; ++part) read(clock.time += cost / 10);
    };
    SimulationLoopOptions options;
    options.tick_limit = 100;
    SimulationLoop loop(model, physics, nullptr, options);
    running = &loop;
    clock.before_sleep = [&](int) {
      const std::int64_t rest = period - (clock.time - start) % period;
      for (int part = 0; part < 10; ++part) read(clock.time + part * rest / 10);
    };
    loop.run(clock);
    INFO(rate_hz << " Hz");
    CHECK(loop.statistics().overrun_count == 0);
    CHECK(reads > 1900);
    CHECK(stale == 0);
  }
}

TEST_CASE("A force that took 200 ms to compute is stale when it comes out", "[force_output]") {
  const Model model = test::smallModel(500);
  test::FakePhysics physics(model);
  test::FakeClock clock;
  physics.on_tick = [&clock](State& state, StepReport&) { clock.time += state.tick == 50 ? 200'000'000 : 500'000; };
  SimulationLoopOptions options;
  options.tick_limit = 51;
  SimulationLoop loop(model, physics, nullptr, options);
  std::vector<ForceReading> after;  // each tick, as soon as it is done
  clock.before_sleep = [&](int) { after.push_back(readForce(loop.force().sample, clock.time, 500)); };
  loop.run(clock);
  REQUIRE(after.size() == 52);
  CHECK_FALSE(after[0].fresh);
  for (std::size_t k = 1; k <= 51; ++k) {
    INFO("after tick " << k);
    CHECK(after[k].sample.tick == static_cast<std::int64_t>(k));
    CHECK(after[k].fresh == (k != 50));
    CHECK(after[k].age_s == Approx(k == 50 ? 0.2 : 5e-4).epsilon(1e-9));
  }
}

TEST_CASE("Every reader gets whole samples that only grow newer", "[force_output]") {
  ForceOutput output;
  constexpr std::int64_t last = 200'000;
  std::atomic<std::int64_t> torn{0}, backwards{0}, seen{0};
  std::vector<std::thread> readers;
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&] {
      for (std::int64_t tick = 0; tick < last;) {
        const ForceSample sample = output.latest();
        torn += !isMarked(sample);
        backwards += sample.tick < tick;
        seen += sample.tick > tick;
        tick = sample.tick;
      }
    });
  }
  for (std::int64_t tick = 1; tick <= last; ++tick) output.publish(marked(tick));
  for (std::thread& reader : readers) reader.join();
  CHECK(torn == 0);
  CHECK(backwards == 0);
  CHECK(seen >= 3);
}

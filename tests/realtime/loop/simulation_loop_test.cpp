#include "realtime/loop/simulation_loop.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("Each tick advances the physics once and gives a force sample at exactly k / rate", "[simulation_loop]") {
  const Model model = smallModel(700);
  FakePhysics physics(model);
  SimulationLoopOptions options = limited(300);
  std::vector<Pose> poses;
  for (int k = 0; k < 300; ++k) poses.push_back(poseAt(Vec3(0, 0, 0.1 - 1e-4 * (k + 1))));
  options.track = trackFromPoses(poses);
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  loop.run(clock);

  CHECK(loop.finished());
  CHECK(physics.calls == 300);
  CHECK(loop.summary().ticks == 300);
  CHECK(loop.summary().totals.realtime_factor == Approx(1).margin(1e-8));  // grid times are whole ns
  const std::vector<ForceSample> samples = drain(loop.forces());
  REQUIRE(samples.size() == 300);
  for (int k = 0; k < 300; ++k) {
    const ForceSample& sample = samples[static_cast<std::size_t>(k)];
    REQUIRE(sample.tick == k + 1);
    REQUIRE(sample.time_s == (k + 1) / 700.0);
    REQUIRE(sample.advance_m == Approx(1e-4 * (k + 1) - model.tools.first().first_contact_travel).margin(1e-15));
    REQUIRE(sample.force_raw.z() == Approx(100 * 1e-4 * (k + 1)));
  }
  CHECK(samples[299].force_filtered.z() < samples[299].force_raw.z());
  CHECK(samples[299].force_filtered.z() > 0.9 * samples[299].force_raw.z());
  CHECK(loop.summary().peak_force == Approx(3.0));
  CHECK(loop.summary().base_reaction.z() == Approx(-3.0));
  CHECK(loop.summary().min_J == 0.9F);
  CHECK(loop.summary().state_hash == physics.stateHash());

  const Snapshot& last = loop.snapshots().latest();
  CHECK(last.tick == 300);
  CHECK(last.time_s == 300 / 700.0);
  CHECK(last.toolPose().position == poses.back().position);
  CHECK(std::equal(last.u.begin(), last.u.end(), physics.state().u.begin(),
                   [](const Float4& a, const Float4& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }));
  REQUIRE(last.contact_count == 1);  // the vertex without force is left out
  CHECK(last.contact_vertex[0] == 1);
  CHECK(last.contact_force[0].z == Approx(-3.0F));
}

TEST_CASE("The state after a script does not depend on how late or slow the ticks were", "[simulation_loop]") {
  const Model model = smallModel();
  SimulationLoopOptions options = limited(500);
  options.track = trackFromPoses(wander(500, 1));
  std::vector<std::uint64_t> hashes;
  for (const bool fast : {false, true}) {
    for (const int slow : {0, 1}) {
      FakePhysics physics(model);
      FakeClock clock;
      clock.late = 100'000 * slow;
      std::mt19937 random(5);
      physics.on_tick = [&](State&, StepReport&) { clock.time += slow * static_cast<int>(random() % 5'000'000); };
      options.as_fast_as_possible = fast;
      SimulationLoop loop(model, physics, nullptr, options);
      loop.run(clock);
      if (slow == 1 && !fast) {
        CHECK(loop.statistics().overrun_count > 100);
        CHECK(loop.summary().totals.realtime_factor ==
              Approx(500.0 / (500.0 + static_cast<double>(loop.statistics().overrun_count))).epsilon(1e-12));
      }
      hashes.push_back(loop.summary().state_hash);
    }
  }
  for (const std::uint64_t hash : hashes) CHECK(hash == hashes[0]);
  FakePhysics untouched(model);
  CHECK(hashes[0] != untouched.stateHash());
}

TEST_CASE("Pause stops time, a single step is one tick, resume goes on", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoop loop(model, physics, nullptr, limited(50));
  FakeClock clock;
  std::vector<int> calls_at_sleep;
  bool told_paused = false;
  clock.before_sleep = [&](int sleep) {
    calls_at_sleep.push_back(physics.calls);
    if (sleep == 10) loop.commands().push(Request::simple(Request::Kind::Pause));
    if (sleep == 20 || sleep == 25) loop.commands().push(Request::simple(Request::Kind::SingleStep));
    if (sleep == 28) told_paused = loop.snapshots().latest().status.paused;
    if (sleep == 30) loop.commands().push(Request::simple(Request::Kind::Resume));
  };
  loop.run(clock);
  CHECK(calls_at_sleep[10] == 10);
  CHECK(calls_at_sleep[20] == 10);
  CHECK(calls_at_sleep[21] == 11);
  CHECK(calls_at_sleep[25] == 11);
  CHECK(calls_at_sleep[30] == 12);
  CHECK(calls_at_sleep[31] == 13);
  CHECK(told_paused);
  CHECK(physics.calls == 50);
  CHECK(loop.statistics().overrun_count == 0);
  CHECK(drain(loop.forces()).back().time_s == 0.1);
  CHECK_FALSE(loop.snapshots().latest().status.paused);
}

TEST_CASE("A run that starts paused begins with Resume, and only a later one is told", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoopOptions options = limited(10);
  options.start_paused = true;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 5) CHECK(physics.calls == 0);
    if (sleep == 5 || sleep == 11) loop.commands().push(Request::simple(Request::Kind::Resume));
    if (sleep == 8) loop.commands().push(Request::simple(Request::Kind::Pause));
  };
  loop.run(clock);
  CHECK(physics.calls == 10);
  std::vector<LogEvent::Kind> told;
  for (const LogEvent& event : drain(loop.log())) told.push_back(event.kind);
  CHECK(told == std::vector{LogEvent::Kind::Paused, LogEvent::Kind::Resumed});
}

TEST_CASE("A tool moved by hand arrives smoothly at the newest pose", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoop loop(model, physics, nullptr, limited(400));
  FakeClock clock;
  const Pose target = poseAt(Vec3(0.01, 0, 0.09), 0.3);
  double largest = 0;
  Vec3 before = model.tools.first().start.pose.position;
  clock.before_sleep = [&](int sleep) {
    const Vec3 now = physics.state().tool[0].pose.position;
    largest = std::max(largest, (now - before).norm());
    before = now;
    if (sleep == 5) {
      Pose nonsense;
      nonsense.position.x() = std::numeric_limits<double>::quiet_NaN();
      loop.commands().push(Request::moveTool(poseAt(Vec3(5, 5, 5))));  // overtaken in the same tick
      loop.commands().push(Request::moveTool(target));
      loop.commands().push(Request::moveTool(nonsense));     // ignored
      loop.commands().push(Request::pull(7, Vec3::Zero()));  // no such vertex: ignored
    }
  };
  loop.run(clock);
  CHECK(physics.state().tool[0].pose.position == target.position);
  CHECK(physics.state().tool[0].pose.orientation.isApprox(target.orientation, 1e-15));
  // A first-order lag of 20 ms: the first of its 2 ms ticks is the largest, 1 - exp(-0.1) of the way.
  CHECK(largest == Approx(std::sqrt(2.0) * 0.01 * (1 - std::exp(-0.1))).epsilon(1e-9));
}

TEST_CASE("A tick takes the requests that were waiting when it began, and leaves those that come meanwhile",
          "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoop loop(model, physics, nullptr, limited(50));
  // A producer without a pause: each request that is taken is followed by the next, 1000 in all.
  int changes = 0;
  physics.on_friction = [&](double friction) {
    if (++changes < 1000) loop.commands().push(Request::setFriction(friction + 0.001));
  };
  FakeClock clock;
  std::vector<int> changes_at_sleep;
  clock.before_sleep = [&](int sleep) {
    changes_at_sleep.push_back(changes);
    if (sleep != 10) return;
    for (int k = 1; k <= 3; ++k) loop.commands().push(Request::setFriction(k));
  };
  loop.run(clock);
  CHECK(physics.calls == 50);
  REQUIRE(changes_at_sleep.size() == 51);
  for (int sleep = 0; sleep <= 50; ++sleep) {
    INFO("sleep " << sleep);
    CHECK(changes_at_sleep[static_cast<std::size_t>(sleep)] == 3 * std::max(0, sleep - 10));
  }
}

TEST_CASE("Reset gives the freshly loaded state, bit for bit", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  const std::uint64_t fresh = physics.stateHash();
  SimulationLoopOptions options;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  std::uint64_t after_reset = 0;
  std::int64_t tick_shown = -1;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 3) loop.commands().push(Request::moveTool(poseAt(Vec3(0.02, 0, 0.05))));
    if (sleep == 100) {
      loop.commands().push(Request::simple(Request::Kind::Pause));
      loop.commands().push(Request::simple(Request::Kind::Reset));
    }
    if (sleep == 101) {
      after_reset = physics.stateHash();
      tick_shown = loop.snapshots().latest().tick;
    }
    if (sleep == 102) loop.commands().push(Request::simple(Request::Kind::Quit));
  };
  loop.run(clock);
  CHECK(after_reset == fresh);
  CHECK(tick_shown == 0);
  CHECK(has(drain(loop.log()), LogEvent::Kind::Reset));
}

TEST_CASE("What is said is told and recorded at its tick, in a pause, too, moves nothing, and a replay says it again",
          "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  const Vec3 place(0.01, -0.02, 1.0 / 3);
  SimulationLoopOptions options = limited(60);
  options.record = true;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 10) loop.commands().push(Request::mark(place, 3));
    if (sleep == 20) loop.commands().push(Request::simple(Request::Kind::Pause));
    if (sleep == 25) loop.commands().push(Request::simple(Request::Kind::Unmark));
    if (sleep == 30) loop.commands().push(Request::simple(Request::Kind::Resume));
    if (sleep == 40) loop.commands().push(Request::simple(Request::Kind::Submit));
  };
  loop.run(clock);
  using Kind = LogEvent::Kind;
  const auto said = [](std::vector<LogEvent> events) {
    std::erase_if(events, [](const LogEvent& event) { return event.kind < Kind::Marked; });
    return events;
  };
  const std::vector<LogEvent> events = said(drain(loop.log()));
  REQUIRE(events.size() == 3);
  CHECK(events[0].kind == Kind::Marked);
  CHECK(events[0].position == place);
  CHECK(events[0].index == 3);
  CHECK(events[1].kind == Kind::Unmarked);
  CHECK(events[1].tick > events[0].tick);
  CHECK(events[2].kind == Kind::Submitted);
  CHECK(events[2].index == -1);
  const std::vector<TimedRequest> recorded = drain(loop.recorded());
  REQUIRE(recorded.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(recorded[k].tick == events[k].tick);

  FakePhysics untold(model), again(model);
  SimulationLoop silent(model, untold, nullptr, limited(60));
  FakeClock other;
  silent.run(other);
  CHECK(untold.stateHash() == physics.stateHash());
  options.track = recorded;
  options.track_ticks = 60;
  SimulationLoop replay(model, again, nullptr, options);
  FakeClock third;
  replay.run(third);
  const std::vector<LogEvent> repeated = said(drain(replay.log()));
  REQUIRE(repeated.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(repeated[k].kind == events[k].kind);
    CHECK(repeated[k].tick == events[k].tick);
    CHECK(repeated[k].position == events[k].position);
  }
  CHECK(repeated[2].index == 1);
}

TEST_CASE("A solution that is lost again and again freezes: the last good shape, a fading force, reset is offered",
          "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  physics.on_tick = [&](State& state, StepReport& report) {
    if (physics.calls < 200 || physics.calls > 203) return;  // three are restored from, the fourth freezes
    state.u[3].y = std::numeric_limits<float>::quiet_NaN();
    report.flags |= kNotFinite;
    report.worst_node = 3;
    report.tool_force.setConstant(std::numeric_limits<double>::quiet_NaN());
  };
  SimulationLoop loop(model, physics, nullptr, limited(600));
  FakeClock clock;
  Snapshot good, frozen;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 1) loop.commands().push(Request::moveTool(poseAt(Vec3(0, 0, 0.08))));
    if (sleep == 202) good = loop.snapshots().latest();  // the third time back
    if (sleep == 450) frozen = loop.snapshots().latest();
    if (sleep == 500) loop.commands().push(Request::simple(Request::Kind::Reset));
  };
  loop.run(clock);

  CHECK(physics.calls == 203 + 100);  // none while frozen
  CHECK(frozen.status.frozen);
  CHECK_FALSE(good.status.frozen);
  for (std::size_t i = 0; i < good.u.size(); ++i) {
    CHECK(good.u[i].x == frozen.u[i].x);
    CHECK(good.u[i].y == frozen.u[i].y);
    CHECK(good.u[i].z == frozen.u[i].z);
  }
  CHECK(frozen.force.force_raw == Vec3::Zero());
  CHECK(frozen.contact_count == 0);

  const std::vector<ForceSample> samples = drain(loop.forces());
  REQUIRE(samples.size() == 600);  // time goes on while frozen
  const double start = samples[201].force_filtered.norm();
  CHECK(start > 1.5);
  double before = start, largest = 0;
  for (std::size_t k = 202; k < 500; ++k) {
    const double now = samples[k].force_filtered.norm();
    REQUIRE(now <= before);
    largest = std::max(largest, before - now);
    before = now;
  }
  CHECK(before == 0);
  CHECK(largest < 0.0121 * start);  // 125 ticks, steepest slope 3/2 of the mean

  bool named = false;
  for (const LogEvent& event : drain(loop.log())) {
    if (!event.isFreeze()) continue;
    named = true;
    CHECK(event.index == 3);
    CHECK(event.position == model.X[3]);
    CHECK(event.tick == 202);  // the tick being run: 0 is the first
  }
  CHECK(named);
  CHECK(loop.summary().flags == kNotFinite);
  CHECK(loop.summary().restored_count == 3);
  CHECK_FALSE(loop.summary().frozen);
  CHECK(std::isfinite(loop.summary().peak_force));
}

#include "realtime/loop/simulation_loop.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"

using namespace palpate;
using namespace palpate::test;

// Replays, viewers that come late or not at all, and real threads.

TEST_CASE("A recorded session, replayed, gives the same state", "[simulation_loop]") {
  const Model model = smallModel();
  Recording recording;
  std::uint64_t hash = 0;
  {
    FakePhysics physics(model);
    SimulationLoopOptions options = limited(800);
    options.record = true;
    SimulationLoop loop(model, physics, nullptr, options);
    FakeClock clock;
    Material soft = model.materials[0], hard = model.materials[0];
    soft.set("young", 2000.0);
    hard.set("young", 3e5);
    clock.before_sleep = [&](int sleep) {
      if (sleep % 8 == 3) {
        loop.commands().push(Request::moveTool(poseAt(Vec3(0.01 * std::sin(0.1 * sleep), 0, 0.09), 0.01 * sleep)));
      }
      if (sleep == 100) loop.commands().push(Request::pull(1, Vec3(0.1, 0.2, 0.3)));
      if (sleep == 140) loop.commands().push(Request::pull(0, Vec3(0.1, 0.2, 0.25)));
      if (sleep == 180) loop.commands().push(Request::simple(Request::Kind::ReleasePull));
      if (sleep == 200) loop.commands().push(Request::setFriction(0.5));
      if (sleep == 220) loop.commands().push(Request::setMaterial(0, soft));
      if (sleep == 230) loop.commands().push(Request::setMaterial(0, hard));  // refused
      if (sleep == 250) loop.commands().push(Request::simple(Request::Kind::Pause));
      if (sleep == 260) loop.commands().push(Request::pull(0, Vec3(0.3, 0.2, 0.3)));
      if (sleep == 300) loop.commands().push(Request::simple(Request::Kind::Resume));
      if (sleep == 400) loop.commands().push(Request::simple(Request::Kind::Reset));
      if (sleep == 420) loop.commands().push(Request::pull(1, Vec3(0.1, 0.1, 0.3)));
    };
    loop.run(clock);
    CHECK(has(drain(loop.log()), LogEvent::Kind::MaterialRefused));
    CHECK(loop.summary().lost_records == 0);
    recording.changes = drain(loop.recorded());
    recording.ticks = loop.summary().ticks;
    hash = loop.summary().state_hash;
  }
  CHECK(recording.changes.size() > 500);

  for (const bool fast : {true, false}) {
    FakePhysics physics(model);
    SimulationLoopOptions options = limited(recording.ticks);
    options.as_fast_as_possible = fast;
    options.record = true;
    options.track = recording.changes;
    options.track_ticks = recording.ticks;
    SimulationLoop loop(model, physics, nullptr, options);
    FakeClock clock;
    clock.before_sleep = [&](int sleep) {  // a viewer who meddles, and may not
      if (sleep == 50) loop.commands().push(Request::moveTool(poseAt(Vec3(1, 1, 1))));
      if (sleep == 51) loop.commands().push(Request::setFriction(0.9));
      if (sleep == 60) loop.commands().push(Request::simple(Request::Kind::Pause));
      if (sleep == 90) loop.commands().push(Request::simple(Request::Kind::Resume));
    };
    loop.run(clock);
    CHECK(loop.summary().state_hash == hash);
    CHECK(drain(loop.recorded()).size() == recording.changes.size());
  }

  // The viewer's reset starts the replay over, friction and material included.
  FakePhysics physics(model);
  SimulationLoopOptions options = limited(300 + recording.ticks);
  options.track = recording.changes;
  options.track_ticks = recording.ticks;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 300) loop.commands().push(Request::simple(Request::Kind::Reset));
  };
  loop.run(clock);
  CHECK(loop.summary().state_hash == hash);

  // And the comparison can fail: a change less is another state.
  FakePhysics other(model);
  options.tick_limit = recording.ticks;
  options.track.pop_back();
  SimulationLoop shorter(model, other, nullptr, options);
  FakeClock again;
  shorter.run(again);
  CHECK(shorter.summary().state_hash != hash);
}

TEST_CASE("When the track is over the viewer has the tool", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoopOptions options = limited(400);
  options.track = trackFromPoses(wander(100, 2));
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  const Vec3 wanted(0.03, 0.03, 0.1);
  Vec3 at_end_of_track;
  clock.before_sleep = [&](int sleep) {
    if (sleep == 50) loop.commands().push(Request::moveTool(poseAt(Vec3(1, 1, 1))));
    if (sleep == 120) at_end_of_track = physics.state().tool[0].pose.position;
    if (sleep == 130) loop.commands().push(Request::moveTool(poseAt(wanted)));
  };
  loop.run(clock);
  CHECK(at_end_of_track == options.track.back().request.pose.position);  // stays where it was left
  CHECK(physics.state().tool[0].pose.position == wanted);
  CHECK(has(drain(loop.log()), LogEvent::Kind::TrackEnded));
}

TEST_CASE("A viewer that takes nothing costs no tick, only what it did not take", "[simulation_loop]") {
  const Model model = smallModel();
  FakePhysics physics(model);
  SimulationLoopOptions options = limited(5000);
  options.force_capacity = 1024;
  options.record = true;
  options.record_capacity = 16;
  options.track = trackFromPoses(wander(5000, 3));
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  loop.run(clock);
  CHECK(physics.calls == 5000);
  CHECK(loop.statistics().overrun_count == 0);
  CHECK(loop.summary().lost_force_samples == 5000 - 1024);
  CHECK(loop.summary().lost_records == 5000 - 16);
  CHECK(drain(loop.forces()).back().tick == 1024);
}

TEST_CASE("A stalled renderer that holds snapshots makes the loop miss no deadline", "[simulation_loop]") {
  const Model model = smallModel(250);
  FakePhysics physics(model);
  SimulationLoop loop(model, physics, nullptr, limited(400));
  loop.start();
  std::int64_t changed = 0, held_ticks = 0;
  while (!loop.finished()) {
    const Snapshot& held = loop.snapshots().latest();
    const std::int64_t tick = held.tick;
    const float x = held.u[0].x;
    // A picture that takes 50 periods. A loop that waited for it would run a tick or two a picture.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    changed += held.tick != tick || held.u[0].x != x;
    held_ticks = std::max<std::int64_t>(held_ticks, loop.statistics().ticks - tick);
  }
  loop.join();
  CHECK(changed == 0);
  CHECK(held_ticks > 10);  // the loop did run on while a snapshot was held
  CHECK(loop.summary().ticks == 400);
  CHECK(loop.snapshots().latest().tick == 400);
  // A machine that is busy with other work may cost some deadlines; waiting for the renderer would cost nearly all.
  CHECK(loop.statistics().overrun_count < 100);
}

TEST_CASE("Under a viewer on another thread, every snapshot is one tick", "[simulation_loop][timed]") {
  const Model model = smallModel(2000);
  FakePhysics physics(model);
  // A tick that marks all of its state with its own number.
  physics.on_tick = [](State& state, StepReport& report) {
    for (Float4& u : state.u) u.x = static_cast<float>(state.tick);
    report.max_increment = static_cast<float>(state.tick);
  };
  SimulationLoopOptions options;
  options.as_fast_as_possible = true;
  options.record = true;
  SimulationLoop loop(model, physics, nullptr, options);
  loop.start();
  std::int64_t mixed = 0, seen = 0, last = -1;
  while (seen < 500) {
    loop.commands().push(Request::moveTool(poseAt(Vec3(0, 0, 0.1 - 1e-5 * static_cast<double>(seen)))));
    const Snapshot& snapshot = loop.snapshots().latest();
    if (snapshot.tick <= std::max<std::int64_t>(last, 0)) {
      mixed += snapshot.tick < last;
      std::this_thread::yield();
      continue;
    }
    for (const Float4& u : snapshot.u) mixed += u.x != static_cast<float>(snapshot.tick);
    mixed += snapshot.report.max_increment != static_cast<float>(snapshot.tick);
    mixed += snapshot.force.tick != snapshot.tick;
    ++seen;
    last = snapshot.tick;
    ForceSample sample;
    while (loop.forces().pop(sample)) mixed += sample.tick <= 0;
    loop.statistics().step.percentiles();
  }
  loop.quit();
  loop.join();
  CHECK(mixed == 0);
  CHECK(loop.summary().ticks >= 500);
}

TEST_CASE("In real time, on its own thread with a team, all periods are ticks or counted as missed",
          "[simulation_loop][timed]") {
  const Model model = smallModel(1000);
  FakePhysics physics(model);
  SpinTeam team(2);
  SimulationLoop loop(model, physics, &team, limited(150));
  loop.start();
  loop.join();
  const RunSummary& summary = loop.summary();
  CHECK(summary.ticks == 150);
  CHECK(loop.statistics().ticks == 150);
  CHECK(loop.statistics().wakeup_late.count() == 150);
  const double periods = 150.0 + static_cast<double>(loop.statistics().overrun_count);
  CHECK(summary.totals.wall_seconds == Approx(1e-3 * periods).epsilon(1e-9));
  CHECK(summary.totals.simulated_seconds == Approx(0.15));
  CHECK(!summary.rt_setup.scheduling.empty());
}

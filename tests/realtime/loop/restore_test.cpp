// A solution that is lost, undoing, and a reset under a hand that stays deep: on tissue, and again from a recording.

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"
#include "support/small_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

const Model& restoredBlock() {
  static const Model model = blockModel(blockScene(0.015));
  return model;
}

struct Live {
  RunSummary summary;
  std::vector<TimedRequest> recorded;
  std::vector<LogEvent> events;
};

/// A session whose `act` may push requests before each tick.
template <class Act>
Live liveRun(const Model& model, TissuePhysics& physics, std::int64_t ticks, const Act& act) {
  SimulationLoopOptions options = limited(ticks);
  options.record = true;
  SimulationLoop loop(model, physics, nullptr, options);
  FakeClock clock;
  clock.before_sleep = [&](int sleep) { act(sleep, loop); };
  loop.run(clock);
  return {loop.summary(), drain(loop.recorded()), drain(loop.log())};
}

RunSummary replayOf(const Live& live, const Model& model) {
  TissuePhysics physics(model, 2);
  SimulationLoopOptions options = limited(live.summary.ticks);
  options.track = live.recorded;
  options.track_ticks = live.summary.ticks;
  options.as_fast_as_possible = true;
  SimulationLoop loop(model, physics, &physics.team(), options);
  FakeClock clock;
  loop.run(clock);
  return loop.summary();
}

}  // namespace

TEST_CASE("A lost solution goes back to a good one, at rest, and the tool comes gently - a recording repeats it",
          "[restore]") {
  Model model = restoredBlock();
  model.max_increment = 0.3 * model.dt;  // m: a blow-up is what goes faster than 0.3 m/s, as under a quick poke
  TissuePhysics physics(model, 1);
  const Pose deep = toolAt(model, 0.010);
  double largest_advance = 0, before = model.tools.first().start.pose.position.z();
  const Live live = liveRun(model, physics, 900, [&](int sleep, SimulationLoop& loop) {
    if (sleep == 3) loop.commands().push(Request::moveTool(deep));
    const double z = physics.state().tool[0].pose.position.z();
    if (loop.snapshots().latest().status.restored_count > 0) largest_advance = std::max(largest_advance, before - z);
    before = z;
  });
  CHECK(live.summary.restored_count >= 1);
  CHECK(live.summary.restored_count <= 2);
  CHECK_FALSE(live.summary.frozen);
  CHECK((live.summary.flags & kBlowUp) != 0);
  CHECK(has(live.events, LogEvent::Kind::RestoredBlowUp));
  CHECK(live.summary.largest_yield > 0.001);
  CHECK(largest_advance <= ToolProxy::approach_speed / model.scene.dynamics.rate_hz + 1e-12);
  CHECK(physics.state().tool[0].pose.position == deep.position);  // it arrived
  CHECK(live.summary.peak_force > 0.05);

  const RunSummary again = replayOf(live, model);
  CHECK(again.state_hash == live.summary.state_hash);
  CHECK(again.restored_count == live.summary.restored_count);
  CHECK(again.largest_yield == live.summary.largest_yield);
}

TEST_CASE("Undo goes back half a second or more, again and again - a recording repeats it", "[restore]") {
  const Model& model = restoredBlock();
  TissuePhysics physics(model, 1);
  std::vector<Pose> way;  // of the tool, by physics tick
  std::vector<std::int64_t> went_back;
  std::int64_t tick = 0;
  const Live live = liveRun(model, physics, 1200, [&](int sleep, SimulationLoop& loop) {
    const State& state = physics.state();
    if (state.tick < tick) {
      went_back.push_back(tick - state.tick);
      CHECK(state.tool[0].pose.position.isApprox(way[static_cast<std::size_t>(state.tick) - 2].position, 1e-12));
    }
    tick = state.tick;
    way.resize(static_cast<std::size_t>(tick));
    if (tick > 0) way.back() = state.tool[0].pose;
    if (sleep % 5 == 0 && sleep < 1000) loop.commands().push(Request::moveTool(toolAt(model, 5e-6 * sleep)));
    if (sleep == 1000 || sleep == 1010) loop.commands().push(Request::simple(Request::Kind::Undo));
  });
  REQUIRE(went_back.size() == 2);
  for (const std::int64_t ticks : went_back) {
    CHECK(ticks >= 100);
    CHECK(ticks <= 400);
  }
  CHECK(live.summary.restored_count == 0);
  CHECK(has(live.events, LogEvent::Kind::Undone));
  CHECK(physics.state().tick < 1200 - 200);
  // The hand's old place is forgotten: the tool stays where it was then.
  CHECK(physics.state().tool[0].pose.position.isApprox(way.back().position, 1e-9));
  CHECK(replayOf(live, model).state_hash == live.summary.state_hash);
}

TEST_CASE("In a pause, the picture after an undo or a reset has the force of its own state", "[restore]") {
  const Model& model = restoredBlock();
  TissuePhysics physics(model, 1);
  std::vector<Vec3> raw(1, Vec3::Zero());  // N, by physics tick
  liveRun(model, physics, 700, [&](int sleep, SimulationLoop& loop) {
    const Snapshot& shown = loop.snapshots().latest();
    if (sleep == 3)
      loop.commands().push(Request::moveTool(toolAt(model, model.tools.first().first_contact_travel + 0.004), 0.3));
    if (sleep == 600) loop.commands().push(Request::simple(Request::Kind::Pause));
    if (sleep < 600) {
      raw.resize(static_cast<std::size_t>(shown.tick) + 1);
      raw.back() = shown.force.force_raw;
    }
    if (sleep == 605) {
      CHECK(shown.status.paused);
      CHECK(shown.force.force_raw.norm() > 0.01);
      loop.commands().push(Request::simple(Request::Kind::Undo));
    }
    if (sleep == 610) {
      REQUIRE(shown.tick < 500);
      const Vec3 then = raw[static_cast<std::size_t>(shown.tick)];
      CHECK(then.norm() > 0.01);
      CHECK((shown.force.force_raw - then).norm() < 1e-4 * then.norm());  // float contact forces, summed anew
      CHECK(shown.force.force_filtered == shown.force.force_raw);
      CHECK(shown.force.depth_m > 0);
      CHECK(shown.status.reset_tick == 0);
      loop.commands().push(Request::simple(Request::Kind::Reset));
    }
    if (sleep == 615) {
      CHECK(shown.tick == 0);
      CHECK(shown.force.force_raw.isZero(0));
      CHECK(shown.force.force_filtered.isZero(0));
      CHECK(shown.force.depth_m < 0);
      CHECK(shown.status.reset_tick == shown.status.ticks);
      loop.commands().push(Request::simple(Request::Kind::Resume));
    }
  });
}

TEST_CASE("Undo with nothing kept changes nothing and says so - while a track lasts it is not the viewer's",
          "[restore]") {
  const Model model = smallModel();
  for (const bool tracked : {false, true}) {
    FakePhysics physics(model);
    SimulationLoopOptions options = limited(tracked ? 1000 : 20);
    if (tracked) options.track = trackFromPoses(wander(1000, 2));
    SimulationLoop loop(model, physics, nullptr, options);
    FakeClock clock;
    clock.before_sleep = [&](int sleep) {
      if (sleep == (tracked ? 900 : 5)) loop.commands().push(Request::simple(Request::Kind::Undo));
    };
    loop.run(clock);
    CHECK(physics.state().tick == loop.summary().ticks);
    const std::vector<LogEvent> events = drain(loop.log());
    CHECK(has(events, LogEvent::Kind::Undone) != tracked);
    for (const LogEvent& event : events)
      if (event.kind == LogEvent::Kind::Undone) CHECK(logText(event).find("nothing to undo") != std::string::npos);
  }
}

TEST_CASE("A reset under a device that stays deep does not dive in again", "[restore][whole]") {
  const Model& model = restoredBlock();
  TissuePhysics physics(model, 1);
  const Pose deep = toolAt(model, 0.008);  // 6 mm in the tissue
  double fastest = 0, fastest_inside = 0;
  Vec3 before = model.tools.first().start.pose.position;
  const Live live = liveRun(model, physics, 900, [&](int sleep, SimulationLoop& loop) {
    loop.commands().push(Request::moveTool(deep));
    if (sleep == 300) loop.commands().push(Request::simple(Request::Kind::Reset));
    const Vec3 now = physics.state().tool[0].pose.position;
    const double speed = (now - before).norm() * model.scene.dynamics.rate_hz;
    if (sleep > 302) fastest = std::max(fastest, speed);
    if (sleep > 302 && before.z() < 0.029) fastest_inside = std::max(fastest_inside, speed);
    before = now;
  });
  CHECK(fastest <= ToolProxy::approach_speed * (1 + 1e-9));
  CHECK(fastest_inside <= ToolProxy::gentle_speed * (1 + 1e-9));
  CHECK(fastest_inside > 0);
  CHECK(physics.state().tool[0].pose.position == deep.position);  // in the end it is there
  CHECK(replayOf(live, model).state_hash == live.summary.state_hash);
}

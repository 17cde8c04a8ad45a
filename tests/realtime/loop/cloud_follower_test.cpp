// A cloud that follows the tool in the loop: swaps between ticks, a worker that is late, replays, undo, saved states.

#include "realtime/loop/cloud_follower.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "model/model_hash.h"
#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/loop_run.h"
#include "realtime/recording/recording.h"
#include "setup/build_model.h"
#include "step/resolution.h"
#include "step/tool_bodies.h"
#include "step/trust.h"
#include "support/equal_models.h"
#include "support/realtime_guard.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

std::shared_ptr<const Places> places() {
  static const auto made = [] {
    Scene scene = test::barScene();
    scene.tools[0].shape.radius = 0.012;  // a third of the nodes
    scene.tools[0].position = Vec3(-0.06, 0, 0.0305);
    return std::make_shared<const Places>(makePlaces(scene, test::barSurface()));
  }();
  return made;
}

/// As a worker makes it; made once for all tests.
std::shared_ptr<const Place> placeAt(const PlaceIndex& index) {
  static std::mutex mutex;
  static std::map<PlaceIndex, std::shared_ptr<const Place>> made;
  const std::lock_guard lock(mutex);
  auto& place = made[index];
  if (!place) place = std::make_shared<const Place>(makePlace(*places(), index));
  return place;
}

std::shared_ptr<PlaceSource> source() {
  static const auto made = std::make_shared<PlaceSource>(places(), placeAt(startPlace(*places())));
  return made;
}

/// A worker that takes up to so long for a place, by a lot of its own.
PlaceWorker::Make late(int most_ms, unsigned seed) {
  auto random = std::make_shared<std::mt19937>(seed);
  return [random, most_ms](const PlaceIndex& index) {
    auto place = placeAt(index);
    std::this_thread::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution<int>(0, most_ms)(*random)));
    return place;
  };
}

std::unique_ptr<FollowingTissue> tissue(int threads = 1, PlaceWorker::Make make = placeAt, bool kept = false) {
  return std::make_unique<FollowingTissue>(source(), threads, false, std::move(make), kept);
}

constexpr int drag_ticks = 250;
constexpr double drag_length = 0.045;  // m

/// Half a radius down in the first fifth, then along the bar.
Pose dragPose(const Model& model, int tick) {
  const double down = std::min(1.0, 5.0 * tick / drag_ticks), along = std::max(0.0, (5.0 * tick / drag_ticks - 1) / 4);
  Pose pose = model.tools.first().start.pose;
  pose.position += Vec3(drag_length * along, 0, -0.0045 * down);
  return pose;
}

SimulationLoopOptions dragging(FollowingTissue& tissue, bool fast) {
  SimulationLoopOptions options;
  options.follower = &tissue.follower;
  options.as_fast_as_possible = fast;
  options.tick_limit = drag_ticks;
  options.record = true;
  std::vector<Pose> poses;
  for (int k = 1; k <= drag_ticks; ++k) poses.push_back(dragPose(tissue.model(), k));
  options.track = test::trackFromPoses(poses);
  return options;
}

struct Run {
  RunSummary summary;
  std::vector<TimedRequest> changes;
};

Run run(FollowingTissue& tissue, SimulationLoopOptions options) {
  SimulationLoop loop(tissue.model(), tissue.physics, &tissue.physics.team(), std::move(options));
  loop.start();
  loop.join();
  return {loop.summary(), test::drain(loop.recorded())};
}

Run replay(FollowingTissue& tissue, const std::vector<TimedRequest>& changes, std::int64_t ticks) {
  SimulationLoopOptions options;
  options.follower = &tissue.follower;
  options.track_has_places = true;
  options.as_fast_as_possible = true;
  options.track = changes;
  options.tick_limit = options.track_ticks = ticks;
  return run(tissue, std::move(options));
}

std::vector<std::int64_t> swapTicks(const std::vector<TimedRequest>& changes) {
  std::vector<std::int64_t> ticks;
  for (const TimedRequest& change : changes)
    if (change.request.kind == Request::Kind::GoToPlace) ticks.push_back(change.tick);
  return ticks;
}

}  // namespace

TEST_CASE("A run that need not keep to the clock has the same bits however late its places are",
          "[cloud_follower][whole]") {
  Run first;
  for (const int k : {0, 1}) {
    const auto body = tissue(1 + k, late(k == 0 ? 0 : 25, 7U + static_cast<unsigned>(k)));
    const Run one = run(*body, dragging(*body, true));
    REQUIRE(one.summary.follow);
    CHECK(one.summary.follow->swaps >= 3);
    CHECK(one.summary.follow->late_ticks == 0);
    CHECK(one.summary.peak_force > 0.05);
    CHECK((one.summary.flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0);
    if (k == 0) first = one;
    CHECK(one.summary.state_hash == first.summary.state_hash);
    CHECK(swapTicks(one.changes) == swapTicks(first.changes));
  }
  // Half a percent of the force here, where the ball is as deep as the bar (place_test.cpp); the tool moves meanwhile.
  CHECK(first.summary.follow->largest_jump_share < 0.05);
}

TEST_CASE("In real time the loop stays where it is until a place is ready, and a replay swaps as it did",
          "[cloud_follower][threads]") {
  Run live;
  {
    // The gate opens long after the tool has left the first place.
    std::atomic<bool> gate{false};
    const auto body = tissue(1, [&](const PlaceIndex& index) {
      while (!gate) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return placeAt(index);
    });
    SimulationLoop loop(body->model(), body->physics, &body->physics.team(), dragging(*body, false));
    test::FakeClock clock;
    clock.before_sleep = [&](int sleep) {
      if (sleep != 120) return;
      gate = true;
      for (int k = 0; k < 6000 && !body->worker.isReady(); ++k)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    };
    loop.run(clock);
    live = {loop.summary(), test::drain(loop.recorded())};
  }
  REQUIRE(live.summary.ticks == drag_ticks);
  const std::vector<std::int64_t> ticks = swapTicks(live.changes);
  CHECK(static_cast<std::int64_t>(ticks.size()) == live.summary.follow->swaps);
  REQUIRE(live.summary.follow->swaps >= 1);
  CHECK(ticks.front() >= 100);
  CHECK(live.summary.follow->late_ticks > 10);
  const auto body = tissue(2, late(20, 11));
  const Run again = replay(*body, live.changes, live.summary.ticks);
  CHECK(again.summary.state_hash == live.summary.state_hash);
  CHECK(again.summary.follow->swaps == live.summary.follow->swaps);
  CHECK(again.summary.peak_force == live.summary.peak_force);
}

TEST_CASE("Undo goes back to the place of that moment, reset to the start, and a recording tells of both",
          "[cloud_follower][whole]") {
  const auto body = tissue();
  SimulationLoopOptions options;
  options.follower = &body->follower;
  options.record = true;
  SimulationLoop loop(body->model(), body->physics, &body->physics.team(), std::move(options));
  const auto drag = [&](int from, int to, int ticks_a_pose) {
    for (int k = from; k < to; ++k) {
      HandPose hand;
      hand.pose = dragPose(body->model(), k);
      loop.hand().back() = hand;
      loop.hand().publish();
      loop.advanceHere(ticks_a_pose);
    }
  };
  drag(1, 200, 2);
  const PlaceIndex before = body->physics.state().place;
  const std::int64_t tick = body->physics.state().tick;
  CHECK(before != startPlace(*places()));
  loop.commands().push(Request::simple(Request::Kind::Undo));
  loop.advanceHere(0);
  const State& state = body->physics.state();
  CHECK(state.tick < tick - 100);
  CHECK(state.place != before);
  CHECK(state.place == body->physics.place()->place.index);
  CHECK(static_cast<int>(state.u.size()) == body->physics.place()->place.model.nodeCount());
  loop.advanceHere(30);
  drag(200, 240, 2);
  CHECK(body->physics.state().place != startPlace(*places()));

  std::vector<TimedRequest> changes = test::drain(loop.recorded());
  const std::int64_t ticks = loop.memory().tick;
  const std::uint64_t hash = body->physics.stateHash();
  loop.commands().push(Request::simple(Request::Kind::Reset));
  loop.advanceHere(0);
  const State fresh = initialState(body->model());
  test::requireSameBits("u", body->physics.state().u, fresh.u);
  CHECK(body->physics.state().place == startPlace(*places()));

  const auto other = tissue(2, late(10, 5));
  CHECK(replay(*other, changes, ticks).summary.state_hash == hash);
}

TEST_CASE("A saved state goes on as it did, also from another place", "[cloud_follower][whole]") {
  const auto body = tissue();
  TissuePhysics& physics = body->physics;
  const std::atomic<bool> stop{false};
  Command command;
  const auto goOn = [&](int from, int to) {
    for (int k = from; k < to; ++k) {
      body->follower.follow(true, stop);
      command.tools[0].pose = dragPose(body->model(), k);
      physics.tick(command);
    }
  };
  goOn(1, 120);
  const State saved = physics.state();
  REQUIRE(saved.place != startPlace(*places()));
  goOn(120, 200);
  const std::uint64_t hash = physics.stateHash();
  REQUIRE(physics.state().place != saved.place);
  REQUIRE(physics.holds(saved.place));
  physics.putIn(saved);
  body->follower.restart();
  goOn(120, 200);
  CHECK(physics.stateHash() == hash);
}

TEST_CASE("What is set live holds at all places", "[cloud_follower][whole]") {
  const auto body = tissue();
  TissuePhysics& physics = body->physics;
  const std::atomic<bool> stop{false};
  const Material soft = stiffened(body->model().materials[0], 0.5);
  REQUIRE(physics.setMaterial(0, soft) == 0);
  physics.setFriction(0, 0.4);
  Command command;
  for (int k = 1; k < 150; ++k) {
    body->follower.follow(true, stop);
    command.tools[0].pose = dragPose(body->model(), k);
    physics.tick(command);
  }
  REQUIRE(body->follower.swapCount() > 1);
  const auto fits = [&](const State& state, const Model& model) {
    State wanted = initialState(model);
    setMaterial(model, 0, soft, wanted);
    CHECK(state.live.friction[0] == 0.4);
    CHECK(state.live.kernel.materials[0] == soft);
    test::requireSameBits("patches", state.live.kernel.patch_bulk, wanted.live.kernel.patch_bulk);
  };
  fits(physics.state(), physics.place()->place.model);
  physics.reset();
  fits(physics.state(), body->model());
}

TEST_CASE("A swap allocates nothing and takes no lock, nor does what keeps its states", "[cloud_follower][whole]") {
  if (!test::guardAvailable()) return;
  const auto body = tissue(2);
  TissuePhysics& physics = body->physics;
  StateHistory history(physics.state(), 500);
  const std::atomic<bool> stop{false};
  Command command;
  test::GuardCounts counts;
  int swaps = 0;
  for (int k = 1; k < 200; ++k) {
    const PlaceIndex present = physics.state().place;
    ToolPostures tools;
    tools[0].pose = physics.state().tool[0].pose;
    const PlaceIndex next = nextPlace(*places(), present, tools);
    PlaceChange* change = nullptr;
    if (next != present) {
      body->worker.want({present, next, no_place});
      while ((change = body->worker.take()) == nullptr) std::this_thread::yield();
      swaps += present != startPlace(*places());
    }
    command.tools[0].pose = dragPose(body->model(), k);
    test::startGuard();
    if (change != nullptr) {
      const auto lost = physics.goTo(*change, 1e9);  // where tissue is squeezed its energy is compared
      if (*lost != no_place) history.forget(*lost);
      body->worker.giveBack(change);
    }
    physics.tick(command);
    history.keep(physics.state(), Doubt::None);
    const test::GuardCounts one = test::stopGuard();
    counts.allocations += one.allocations;
    counts.frees += one.frees;
    counts.locks += one.locks;
  }
  CHECK(swaps >= 2);
  CHECK(counts.allocations == 0);
  CHECK(counts.frees == 0);
  CHECK(counts.locks == 0);
}

TEST_CASE("A change that is refused leaves no trace, and can be made later", "[cloud_follower][whole]") {
  const auto body = tissue();
  TissuePhysics& physics = body->physics;
  // Down at 0.5 m/s, then along with the tissue under it.
  Command command;
  const auto press = [&](int from, int to) {
    for (int k = from; k < to; ++k) {
      command.tools[0].pose = body->model().tools.first().start.pose;
      command.tools[0].pose.position += Vec3(0.0005 * std::max(0, k - 20), 0, -0.001 * std::min(k, 20));
      physics.tick(command);
    }
  };
  press(1, 60);
  REQUIRE(physics.state().local_mass.active);
  const State before = physics.state();
  press(60, 80);
  const std::uint64_t hash = physics.stateHash();
  physics.putIn(before);
  const PlaceIndex here = before.place;
  const PlaceIndex next = nextPlace(*places(), here, posturesOf(before));
  REQUIRE(next != here);
  PlaceChange* change = nullptr;
  body->worker.want({here, next, no_place});
  while ((change = body->worker.take()) == nullptr) std::this_thread::yield();
  PlaceChange unused(change->from, change->to, *places());
  const auto refuse = [&] { return !physics.goTo(*change, -0.5).has_value(); };  // whatever it brings
  CHECK(refuse());
  CHECK(physics.state().place == here);
  press(60, 80);
  CHECK(physics.stateHash() == hash);
  CHECK(refuse());  // of another state, which the next try must not remember
  const auto goesOn = [&](PlaceChange& by) {
    physics.putIn(before);
    physics.goTo(by);
    press(60, 80);
    return physics.stateHash();
  };
  const std::uint64_t again = goesOn(*change);
  CHECK(physics.state().place == next);
  CHECK(again == goesOn(unused));
  body->worker.giveBack(change);
}

TEST_CASE("Tissue bent between coarse nodes is not followed until it is straight", "[cloud_follower][whole]") {
  const auto body = tissue();
  TissuePhysics& physics = body->physics;
  const std::atomic<bool> stop{false};
  State bent = physics.state();
  bent.tool[0].pose.position.x() += 1.5 * places()->sizes.stride;
  const PlaceIndex next = nextPlace(*places(), bent.place, posturesOf(bent));
  REQUIRE(next != bent.place);
  bent.local_mass.active = true;
  // To and fro at the coarse nodes that the ball leaves, at rest at the fine ones between them, which go.
  const Place& here = *placeAt(bent.place);
  const auto inBall = [&](const PlaceIndex& index, const Vec3& X) {
    return (X - places()->centres[static_cast<std::size_t>(index[0])]).norm() < ball_radii * 0.012;
  };
  float sign = 1e-4F;
  for (std::size_t i = 0; i < here.node.size(); ++i)
    if (inBall(bent.place, here.model.X[i]) && !inBall(next, here.model.X[i]) &&
        places()->body[0].cloud.coarsest[static_cast<std::size_t>(here.node[i])] >= places()->sizes.coarse)
      bent.u[i].z = sign = -sign;
  const auto follows = [&](std::int64_t tick) {
    bent.tick = tick;
    physics.putIn(bent);
    return body->follower.follow(true, stop);
  };
  CHECK_FALSE(follows(8 * 19));  // not yet one at which it is tried
  CHECK_FALSE(body->follower.isLate());
  CHECK_FALSE(follows(32 * 5));
  CHECK(body->follower.isLate());
  CHECK(physics.state().place == bent.place);

  for (Float4& u : bent.u) u = {};
  bent.local_mass.active = false;
  CHECK_FALSE(follows(8 * 21 + 3));
  CHECK(follows(8 * 22));
  CHECK_FALSE(body->follower.isLate());
  CHECK(physics.state().place == next);
}

TEST_CASE("Where nodes are too far apart for the tool an error is expected, whatever the tissue's own estimate says",
          "[cloud_follower][whole]") {
  const auto body = tissue();
  CHECK(body->follower.expectedError() == 0);
  State beside = body->physics.state();
  beside.tool[0].pose.position.x() += 0.1;  // beyond the ball
  body->physics.putIn(beside);
  const double apart = places()->sizes.coarse / (coarsest_nodes * 0.012);
  REQUIRE(apart > 1);
  CHECK(body->follower.expectedError() == Approx(TrustLimits::expected_error * apart * apart));
}

TEST_CASE("While the loop stays where it is the places around are made, and no more", "[cloud_follower][whole]") {
  const bool kept = GENERATE(false, true);  // on disk: there they are enough
  const auto body = tissue(1, placeAt, kept);
  body->keepToClock();
  const PlaceIndex start = startPlace(*places());
  std::vector<std::pair<double, int>> around;
  const auto& centres = places()->centres;
  for (int c = 0; c < static_cast<int>(centres.size()); ++c)
    if (c != start[0])
      around.emplace_back((centres[static_cast<std::size_t>(c)] - centres[static_cast<std::size_t>(start[0])]).norm(),
                          c);
  std::sort(around.begin(), around.end());
  REQUIRE(around[0].first < 1.8 * places()->sizes.stride);
  const int wanted = static_cast<int>(std::min<std::ptrdiff_t>(
      kept ? 6 : 3, std::count_if(around.begin(), around.end(),
                                  [](const auto& a) { return a.first <= 1.8 * places()->sizes.stride; })));
  for (int k = 0; k < wanted; ++k) {  // here, as the worker gives way to all other programs
    PlaceIndex index = start;
    index[0] = around[static_cast<std::size_t>(k)].second;
    placeAt(index);
  }
  body->worker.want({start, no_place, no_place});
  while (body->worker.madeCount() < wanted) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  // The nearest is there: going to it makes none, or reads it.
  PlaceIndex nearest = start;
  nearest[0] = around[0].second;
  body->worker.want({start, nearest, no_place});
  PlaceChange* change = nullptr;
  while ((change = body->worker.take()) == nullptr) std::this_thread::yield();
  CHECK(change->to->place.index == nearest);
  CHECK(body->worker.madeCount() == wanted + (kept ? 1 : 0));
  body->worker.giveBack(change);
}

TEST_CASE("Where a place can't be made the loop stays where it is, and says why", "[cloud_follower][whole]") {
  for (const bool fast : {true, false}) {
    const PlaceIndex start = startPlace(*places());
    const auto body = tissue(
        1, [](const PlaceIndex&) -> std::shared_ptr<const Place> { throw InputError({}, "no such place", "nothing"); });
    const Run one = run(*body, dragging(*body, fast));
    CHECK(one.summary.ticks == drag_ticks);
    CHECK(one.summary.follow->swaps == 0);
    CHECK(one.summary.follow->late_ticks > drag_ticks / 2);
    CHECK(body->physics.state().place == start);
    CHECK_THAT(body->worker.failure(), Catch::Contains("no such place"));
  }
}

// What the loop's thread must never do while ticks run: allocate, lock, make system calls other than the sleep and
// looks at its own use of the processor. The real clock and the real SimulationLoop, on a fake physics;
// tissue_physics_test.cpp holds the tissue's own step, on each thread of its team, to the same.

#include <sys/syscall.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "realtime/team_guard.h"
#include "support/realtime_guard.h"

using namespace palpate;
using test::ClockWithStart;
using test::FakePhysics;
using test::smallModel;

namespace {

/// A session with everything in it: moves, pulls, live changes, freeze, reset, pause.
struct Session {
  Session() : model(smallModel(2000)), physics(model) {
    physics.on_tick = [this](State& state, StepReport& report) {
      if (state.tick == 60) report.flags |= kBlowUp;
      if (state.tick % 20 == 5) {
        report.flags |= kInvertedPoints;
        report.inverted_points = 1;
      }
      if (spoil) spoil(state.tick);
    };
    SimulationLoopOptions options;
    options.tick_limit = 200;
    options.record = true;
    options.force_capacity = 64;  // overflows, too
    options.track = {{5, Request::pull(1, Vec3(0, 0, 0.1))},
                     {10, Request::setFriction(0.3)},
                     {12, Request::setMaterial(0, model.materials[0])},
                     {15, Request::simple(Request::Kind::ReleasePull)},
                     {90, Request::simple(Request::Kind::Reset)}};
    for (int k = 91; k < 150; ++k) {
      Pose pose;
      pose.position.z() = 0.1 - 1e-4 * k;
      options.track.push_back({k, Request::moveTool(pose)});
    }
    loop = std::make_unique<SimulationLoop>(model, physics, nullptr, options);
    loop->commands().push(Request::simple(Request::Kind::Pause));
    loop->commands().push(Request::simple(Request::Kind::Resume));
    for (int k = 0; k < 20; ++k) loop->commands().push(Request::moveTool(Pose{}));
  }

  Model model;
  FakePhysics physics;
  std::function<void(std::int64_t)> spoil;
  std::unique_ptr<SimulationLoop> loop;
};

test::GuardCounts guardedRun(Session& session) {
  ClockWithStart clock(test::startGuard);
  session.loop->run(clock);
  return test::stopGuard();
}

constexpr int kAllDone = 17;

/// Runs the session in a child process that may only sleep; its exit code.
int exitCodeUnderFilter(Session& session) {
  return test::exitCodeOfChild([&session] {
    ClockWithStart clock(test::allowOnlySleeping);
    session.loop->run(clock);
    return session.loop->summary().ticks == 200 ? kAllDone : 1;
  });
}

}  // namespace

TEST_CASE("The loop's thread neither allocates nor locks", "[realtime_safety]") {
  if (!test::guardAvailable()) return;  // under a sanitizer; the release preset has it
  Session session;
  const test::GuardCounts counts = guardedRun(session);
  CHECK(counts.allocations == 0);
  CHECK(counts.frees == 0);
  CHECK(counts.locks == 0);
  // The session was what it says.
  CHECK(session.loop->summary().ticks == 200);
  CHECK(session.loop->summary().flags == (kBlowUp | kInvertedPoints));
  CHECK(session.loop->summary().lost_force_samples == 200 - 64);
  CHECK(session.loop->recorded().size() > 50);
  CHECK(session.loop->log().size() >= 6);
}

TEST_CASE("The guard sees allocations and locks in a tick", "[realtime_safety]") {
  if (!test::guardAvailable()) return;
  {
    Session session;
    session.spoil = [](std::int64_t tick) {
      if (tick == 20) std::vector<int>(100).swap(*std::make_unique<std::vector<int>>());
    };
    const test::GuardCounts counts = guardedRun(session);
    CHECK(counts.allocations >= 2);
    CHECK(counts.frees >= 2);
  }
  {
    Session session;
    std::mutex mutex;
    session.spoil = [&mutex](std::int64_t tick) {
      if (tick == 20) std::lock_guard<std::mutex> lock(mutex);
    };
    CHECK(guardedRun(session).locks >= 1);
  }
}

TEST_CASE("The guard sees what each worker does, and whose it is", "[realtime_safety]") {
  if (!test::guardAvailable()) return;
  SpinTeam team(3);
  std::vector<test::GuardCounts> counts(3);
  std::mutex mutex;
  const auto spoil = [](void* shared, int member, int) {
    if (member == 1) std::vector<int>(100).swap(*std::make_unique<std::vector<int>>());
    if (member == 2) std::lock_guard<std::mutex> lock(*static_cast<std::mutex*>(shared));
  };
  test::startGuard(team);
  team.run(spoil, &mutex);
  test::stopGuard(team, counts);
  CHECK(counts[0].total() == 0);
  CHECK(counts[1].allocations >= 1);
  CHECK(counts[1].frees >= 1);
  CHECK(counts[1].locks == 0);
  CHECK(counts[2].allocations == 0);
  CHECK(counts[2].locks >= 1);
}

TEST_CASE("The loop's thread makes no system call but the sleep and looks at its own use of the processor",
          "[realtime_safety]") {
  if (!test::guardAvailable()) return;  // sanitizers make calls of their own
  Session session;
  const int code = exitCodeUnderFilter(session);
  if (code == test::kNoFilter) {
    WARN("seccomp is not permitted here: system calls are not checked");
    return;
  }
  INFO("100 + number of a system call, mod 100, if above 99");
  CHECK(code == kAllDone);

  Session spoiled;
  spoiled.spoil = [](std::int64_t tick) {
    if (tick == 20) syscall(SYS_getppid);
  };
  CHECK(exitCodeUnderFilter(spoiled) == 100 + SYS_getppid % 100);
}

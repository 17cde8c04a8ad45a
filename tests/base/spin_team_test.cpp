#include "base/spin_team.h"

#include <sched.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

using palpate::shareOut;
using palpate::SpinTeam;

namespace {

struct Tally {
  explicit Tally(int size) : calls(static_cast<std::size_t>(size), 0) {}
  std::vector<std::int64_t> calls;  // per member; plain, so that tsan sees a missing barrier
  std::int64_t wrong_count = 0;     // member 0's
};

void countCall(void* context, int member, int member_count) {
  auto& tally = *static_cast<Tally*>(context);
  ++tally.calls[static_cast<std::size_t>(member)];
  if (member == 0 && member_count != static_cast<int>(tally.calls.size())) ++tally.wrong_count;
}

/// A chain through all members: each writes what it read of its neighbour's last value.
struct Chain {
  std::vector<std::int64_t> now, next;
};

void shiftChain(void* context, int member, int member_count) {
  auto& chain = *static_cast<Chain*>(context);
  const auto m = static_cast<std::size_t>(member);
  chain.next[m] = chain.now[(m + 1) % static_cast<std::size_t>(member_count)] + 1;
}

void copyChain(void* context, int member, int) {
  auto& chain = *static_cast<Chain*>(context);
  chain.now[static_cast<std::size_t>(member)] = chain.next[static_cast<std::size_t>(member)];
}

}  // namespace

TEST_CASE("Every member of a team runs each job once", "[spin_team]") {
  for (int size = 1; size <= 4; ++size) {
    SpinTeam team(size);
    REQUIRE(team.size() == size);
    Tally tally(size);
    constexpr int ticks = 200, jobs_per_tick = 5;
    for (int t = 0; t < ticks; ++t) {
      team.wake();
      for (int j = 0; j < jobs_per_tick; ++j) team.run(countCall, &tally);
      team.park();
    }
    for (int j = 0; j < 50; ++j) team.run(countCall, &tally);  // parked: run wakes by itself
    for (const std::int64_t calls : tally.calls) CHECK(calls == ticks * jobs_per_tick + 50);
    CHECK(tally.wrong_count == 0);
  }
}

TEST_CASE("A job sees what all members wrote in the job before", "[spin_team]") {
  constexpr int rounds = 1000;
  for (int size = 1; size <= 4; ++size) {
    SpinTeam team(size);
    Chain chain;
    for (int m = 0; m < size; ++m) chain.now.push_back(100 * m);
    chain.next = chain.now;
    team.wake();
    for (int r = 0; r < rounds; ++r) {
      team.run(shiftChain, &chain);
      team.run(copyChain, &chain);
    }
    team.park();
    for (int m = 0; m < size; ++m) {
      CHECK(chain.now[static_cast<std::size_t>(m)] == 100 * ((m + rounds) % size) + rounds);
    }
  }
}

TEST_CASE("A late member delays a job but all of it is done", "[spin_team]") {
  SpinTeam team(3);
  struct Late {
    std::vector<int> done = std::vector<int>(3, 0);
    int round = 0;
  } late;
  for (late.round = 0; late.round < 30; ++late.round) {
    team.run(
        [](void* context, int member, int) {
          auto& l = *static_cast<Late*>(context);
          // Longer than spinning and yielding last: the others go to sleep and must be woken.
          if (l.round % 3 == member) std::this_thread::sleep_for(std::chrono::milliseconds(3));
          ++l.done[static_cast<std::size_t>(member)];
        },
        &late);
    for (const int done : late.done) REQUIRE(done == late.round + 1);
  }
}

TEST_CASE("Each part of a shared job is done once, and seen by the next job", "[spin_team]") {
  for (int size = 1; size <= 4; ++size) {
    SpinTeam team(size);
    for (const int count : {0, 1, 2, 7, 16, 300}) {
      std::vector<std::int64_t> now(static_cast<std::size_t>(count)), next = now;
      std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
      constexpr int rounds = 200;
      for (int r = 0; r < rounds; ++r) {
        if (r % 50 == 0) team.wake();
        shareOut(team, count, [&](int part) {
          ++done[part];
          next[part] = now[(part + 1) % count] + 1;
        });
        shareOut(team, count, [&](int part) { now[part] = next[part]; });
        if (r % 50 == 40) team.park();
      }
      team.park();
      for (const std::int64_t n : now) CHECK(n == rounds);
      for (const auto& n : done) CHECK(n == rounds);
    }
  }
}

TEST_CASE("What a late member does not come to, the others do", "[spin_team]") {
  SpinTeam team(2);
  std::atomic<bool> held{false}, let_go{false};
  // The worker is held in its first part until the owner has taken the last one from it.
  std::vector<int> done(8, 0);
  shareOut(team, 8, [&](int part) {
    ++done[part];
    if (part == 4) {  // the first of the worker's own
      held = true;
      while (!let_go) std::this_thread::yield();
    } else if (part == 0) {
      while (!held) std::this_thread::yield();
    } else if (part == 7) {
      let_go = true;
    }
  });
  CHECK(done == std::vector<int>(8, 1));
}

TEST_CASE("A team can end while a worker is still coming to a job that is over", "[spin_team]") {
  std::atomic<int> done{0};
  for (int k = 0; k < 300; ++k) {
    SpinTeam team(2);
    if (k % 2 == 0) team.wake();
    shareOut(team, 2, [&](int) { ++done; });
  }
  CHECK(done == 600);
}

TEST_CASE("A worker that keeps the owner waiting is noticed", "[spin_team]") {
  SpinTeam team(2);
  const auto job = [](void* slow, int member, int) {
    if (member == 1 && *static_cast<bool*>(slow)) std::this_thread::sleep_for(std::chrono::milliseconds(3));
  };
  bool slow = true;
  for (int k = 0; k < 5; ++k) team.run(job, &slow);
  CHECK(team.longWaits() == 5);
  SpinTeam alone(1);
  alone.run(job, &slow);
  CHECK(alone.longWaits() == 0);
}

TEST_CASE("A team larger than its only core comes to an end", "[spin_team]") {
  cpu_set_t before;
  REQUIRE(sched_getaffinity(0, sizeof before, &before) == 0);
  int core = 0;
  while (!CPU_ISSET(core, &before)) ++core;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(core, &one);
  REQUIRE(sched_setaffinity(0, sizeof one, &one) == 0);  // inherited by the workers
  {
    SpinTeam team(4);
    Tally tally(4);
    for (int t = 0; t < 20; ++t) {
      team.wake();
      for (int j = 0; j < 5; ++j) team.run(countCall, &tally);
      team.park();
    }
    for (const std::int64_t calls : tally.calls) CHECK(calls == 100);
  }
  REQUIRE(sched_setaffinity(0, sizeof before, &before) == 0);
}

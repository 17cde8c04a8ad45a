#include "realtime/loop/thread_setup.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <catch2/catch.hpp>
#include <thread>
#include <vector>

using namespace palpate;

namespace {

bool flushes() {
  volatile float small = 1e-30F;
  const volatile float product = small * 1e-10F;  // 1e-40: a denormal
  return product == 0.0F;
}

bool done(const std::string& text) { return text.rfind("done: ", 0) == 0; }
bool reasoned(const std::string& text) { return done(text) || (text.rfind("not done: ", 0) == 0 && text.size() > 15); }

/// On a thread of its own: what is asked for must not stick to the tests after this one.
template <class Function>
void onOtherThread(Function function) {
  std::thread(function).join();
}

}  // namespace

TEST_CASE("Denormals are flushed on each thread of the team", "[thread_setup]") {
  REQUIRE_FALSE(flushes());
  onOtherThread([] {
    SpinTeam team(3);
    const RtSetup setup = setUpLoopThread(&team, false);
    std::vector<char> flushed(3, 0);
    team.run([](void* context, int member,
                int) { (*static_cast<std::vector<char>*>(context))[static_cast<std::size_t>(member)] = flushes(); },
             &flushed);
    CHECK(flushed == std::vector<char>(3, done(setup.denormals)));
    CHECK_FALSE(done(setup.scheduling));  // as fast as possible: not asked
  });
  CHECK_FALSE(flushes());
}

TEST_CASE("Each thing asked of the system is done, or there is a reason", "[thread_setup][timed]") {
  onOtherThread([] {
    SpinTeam team(2);
    const RtSetup setup = setUpLoopThread(&team, true);
    CHECK(reasoned(setup.scheduling));
    CHECK(reasoned(setup.memory_lock));
    CHECK(reasoned(setup.affinity));
    CHECK(reasoned(setup.denormals));
    CHECK((sched_getscheduler(0) == SCHED_FIFO) == done(setup.scheduling));
    cpu_set_t cores;
    REQUIRE(sched_getaffinity(0, sizeof cores, &cores) == 0);
    if (done(setup.affinity)) CHECK(CPU_COUNT(&cores) == 1);
    // While nobody is there they are ordinary threads, and have again what they had when somebody comes.
    for (const bool yes : {true, false}) {
      onOtherThread([&] { giveWay(setup, yes); });
      for (const int id : setup.thread_ids)
        CHECK((sched_getscheduler(id) == SCHED_FIFO) == (done(setup.scheduling) && !yes));
      REQUIRE(sched_getaffinity(0, sizeof cores, &cores) == 0);
      if (done(setup.affinity)) CHECK((CPU_COUNT(&cores) == 1) == !yes);
    }
    munlockall();
  });
  CHECK(sched_getscheduler(0) == SCHED_OTHER);
}

TEST_CASE("More physics threads than cores are not pinned", "[thread_setup]") {
  onOtherThread([] {
    cpu_set_t allowed;
    REQUIRE(sched_getaffinity(0, sizeof allowed, &allowed) == 0);
    SpinTeam team(CPU_COUNT(&allowed) + 1);
    const RtSetup setup = setUpLoopThread(&team, true);
    CHECK(setup.affinity.rfind("not done: ", 0) == 0);
    munlockall();
  });
}

TEST_CASE("After its loop a team's workers are ordinary threads again, on any core", "[thread_setup]") {
  SpinTeam team(2);
  const auto prepare = [&] {
    setUpLoopThread(&team, true);
    munlockall();
  };
  onOtherThread(prepare);
  cpu_set_t allowed;
  REQUIRE(sched_getaffinity(0, sizeof allowed, &allowed) == 0);
  endRealTime(team);
  for (std::thread& worker : team.workers()) {
    int policy = -1;
    sched_param priority{};
    REQUIRE(pthread_getschedparam(worker.native_handle(), &policy, &priority) == 0);
    CHECK(policy == SCHED_OTHER);
    cpu_set_t cores;
    REQUIRE(pthread_getaffinity_np(worker.native_handle(), sizeof cores, &cores) == 0);
    CHECK(CPU_EQUAL(&cores, &allowed));
  }
}

TEST_CASE("The viewer's thread gives way, alone", "[thread_setup]") {
  onOtherThread([] { CHECK(reasoned(setUpViewerThread())); });
}

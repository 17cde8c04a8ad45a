#include "realtime/loop/thread_setup.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace palpate {
namespace {

// Above all ordinary work, and below the kernel's threaded interrupts (50 by default),
// which drivers need.
constexpr int kPriority = 40;

// What the loop's thread may use of its stack without a page fault.
constexpr std::size_t kTouchedStack = 128 * 1024;

std::string refused(int error, const std::string& advice) {
  return std::string("not done: ") + std::strerror(error) + "; " + advice;
}

std::vector<pthread_t> threadsOf(SpinTeam* team) {
  std::vector<pthread_t> threads{pthread_self()};
  if (team != nullptr) {
    for (std::thread& worker : team->workers()) threads.push_back(worker.native_handle());
  }
  return threads;
}

/// All threads get the class, or none does: a worker of a lower class than the owner, on
/// the owner's core, could not run while the owner waits for it.
std::string setScheduling(const std::vector<pthread_t>& threads, bool& granted) {
  granted = false;
  sched_param priority{};
  priority.sched_priority = kPriority;
  for (std::size_t t = 0; t < threads.size(); ++t) {
    const int error = pthread_setschedparam(threads[t], SCHED_FIFO, &priority);
    if (error == 0) continue;
    const sched_param ordinary{};
    for (std::size_t done = 0; done < t; ++done) pthread_setschedparam(threads[done], SCHED_OTHER, &ordinary);
    return refused(error, "allow real-time priority (ulimit -r 40, or CAP_SYS_NICE)");
  }
  granted = true;
  return "done: SCHED_FIFO, priority " + std::to_string(kPriority) + ", " + std::to_string(threads.size()) +
         (threads.size() == 1 ? " thread" : " threads");
}

std::string lockMemory() {
  // MCL_ONFAULT: pages in use stay in memory, and untouched ones (libraries, stacks) are not read in.
  // No MCL_FUTURE: what is mapped later belongs to the viewer, and would count against the limit.
  if (mlockall(MCL_CURRENT | MCL_ONFAULT) == 0) return "done: pages in use are locked";
  return refused(errno, "allow locked memory (ulimit -l unlimited, or CAP_IPC_LOCK)");
}

std::string setAffinity(const std::vector<pthread_t>& threads, bool fifo, std::vector<int>& pinned) {
  if (!fifo) return "not done: without SCHED_FIFO a pinned thread can't leave a busy core";
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return refused(errno, "the loop runs on any core");
  std::vector<int> cores;
  for (int core = CPU_SETSIZE - 1; core >= 0; --core) {
    if (CPU_ISSET(core, &allowed)) cores.push_back(core);
  }
  if (cores.size() < threads.size()) {
    return "not done: " + std::to_string(threads.size()) + " physics threads, but only " +
           std::to_string(cores.size()) + " cores allowed";
  }
  std::string names;
  for (std::size_t t = 0; t < threads.size(); ++t) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cores[t], &one);
    const int error = pthread_setaffinity_np(threads[t], sizeof one, &one);
    if (error != 0) return refused(error, "the loop runs on any core");
    names += (t > 0 ? ", " : "") + std::to_string(cores[t]);
  }
  pinned = cores;
  return (threads.size() == 1 ? "done: core " : "done: cores ") + names;
}

void touchStack() {
  [[maybe_unused]] volatile char stack[kTouchedStack];
  for (std::size_t i = 0; i < kTouchedStack; i += 4096) stack[i] = 0;
}

struct MemberSetup {
  bool real_time;
  std::vector<int> thread_ids;  // (member_count)
};

void setUpMember(void* context, int member, int) {
  auto& setup = *static_cast<MemberSetup*>(context);
  setup.thread_ids[static_cast<std::size_t>(member)] = static_cast<int>(syscall(SYS_gettid));
  flushDenormals();
  if (!setup.real_time) return;
  touchStack();
  // The kernel may delay an ordinary thread's wake-up by its timer slack, 50 us by default.
  prctl(PR_SET_TIMERSLACK, 1UL);
}

}  // namespace

void flushDenormals() {
#if defined(__SSE__)
  constexpr unsigned kFlushToZero = 0x8000, kDenormalsAreZero = 0x0040;
  _mm_setcsr(_mm_getcsr() | kFlushToZero | kDenormalsAreZero);
#endif
}

FlushedDenormals::FlushedDenormals() {
#if defined(__SSE__)
  before_ = _mm_getcsr();
#endif
  flushDenormals();
}

FlushedDenormals::~FlushedDenormals() {
#if defined(__SSE__)
  _mm_setcsr(before_);
#endif
}

RtSetup setUpLoopThread(SpinTeam* team, bool real_time) {
  RtSetup setup;
  MemberSetup members{real_time, std::vector<int>(team != nullptr ? static_cast<std::size_t>(team->size()) : 1)};
  if (team != nullptr) {
    team->run(setUpMember, &members);
  } else {
    setUpMember(&members, 0, 1);
  }
  setup.thread_ids = std::move(members.thread_ids);
#if defined(__SSE__)
  setup.denormals = "done: flush-to-zero and denormals-are-zero";
#else
  setup.denormals = "not done: no SSE control register on this processor";
#endif
  if (!real_time) {
    setup.scheduling = setup.memory_lock = setup.affinity = "not done: not wanted as fast as possible";
    return setup;
  }
  const std::vector<pthread_t> threads = threadsOf(team);
  bool fifo = false;
  setup.scheduling = setScheduling(threads, fifo);
  setup.memory_lock = lockMemory();
  setup.affinity = setAffinity(threads, fifo, setup.cores);
  return setup;
}

void endRealTime(SpinTeam& team) {
  const sched_param ordinary{};
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  const bool known = sched_getaffinity(0, sizeof allowed, &allowed) == 0;
  for (std::thread& worker : team.workers()) {
    pthread_setschedparam(worker.native_handle(), SCHED_OTHER, &ordinary);
    if (known) pthread_setaffinity_np(worker.native_handle(), sizeof allowed, &allowed);
  }
}

void giveWay(const RtSetup& setup, bool yes) {
  if (!setup.scheduling.starts_with("done: ")) return;
  sched_param priority{};
  priority.sched_priority = yes ? 0 : kPriority;
  for (std::size_t t = 0; t < setup.thread_ids.size(); ++t) {
    sched_setscheduler(setup.thread_ids[t], yes ? SCHED_OTHER : SCHED_FIFO, &priority);
    if (setup.cores.empty()) continue;
    cpu_set_t cores;
    CPU_ZERO(&cores);
    for (std::size_t c = 0; c < setup.cores.size(); ++c)
      if (yes || c == t) CPU_SET(setup.cores[c], &cores);
    sched_setaffinity(setup.thread_ids[t], sizeof cores, &cores);
  }
}

std::string setUpViewerThread() {
  constexpr int kNice = 10;
  // On Linux, a thread's own id addresses this thread alone.
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (setpriority(PRIO_PROCESS, thread, kNice) == 0) return "done: nice " + std::to_string(kNice);
  return refused(errno, "the picture may disturb the loop");
}

}  // namespace palpate

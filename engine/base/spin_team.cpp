#include "base/spin_team.h"

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace palpate {
namespace {

// The wait between two jobs of a tick is about a microsecond, and a barrier that spins
// costs 0.15 us where one that sleeps costs 5. Longer waits mean that a member has lost
// its core: then spinning keeps that core from it.
constexpr int kSpins = 2000;  // pauses of ~40 ns: some 50-100 us
constexpr int kYields = 100;

inline void pause() {
#if defined(__x86_64__) || defined(__i386__)
  _mm_pause();
#endif
}

/// One waiting round: pause, later yield. False when it is time to sleep on a futex.
class Backoff {
 public:
  bool wait() {
    if (rounds_ < kSpins) {
      pause();
    } else if (rounds_ < kSpins + kYields) {
      std::this_thread::yield();
    } else {
      return false;
    }
    ++rounds_;
    return true;
  }

  bool isLong() const { return rounds_ > kSpins; }

 private:
  int rounds_ = 0;
};

}  // namespace

SpinTeam::SpinTeam(int thread_count) : size_(thread_count < 1 ? 1 : thread_count) {
  workers_.reserve(static_cast<std::size_t>(size_ - 1));
  for (int member = 1; member < size_; ++member) {
    workers_.emplace_back([this, member] { work(member); });
  }
}

SpinTeam::~SpinTeam() {
  stop_ = true;
  generation_.fetch_add(1);
  generation_.notify_all();
  wake();
  for (std::thread& worker : workers_) worker.join();
}

void SpinTeam::run(Job job, void* context) {
  if (size_ == 1) {
    job(context, 0, 1);
    return;
  }
  const bool parked = (awake_.load(std::memory_order_relaxed) & 1u) == 0;
  job_ = job;
  context_ = context;
  remaining_.store(size_ - 1, std::memory_order_relaxed);
  generation_.fetch_add(1);  // sequentially consistent: ordered before notify's look for sleepers
  generation_.notify_all();
  if (parked) wake();

  job(context, 0, size_);

  Backoff backoff;
  for (int left = remaining_.load(std::memory_order_acquire); left != 0;
       left = remaining_.load(std::memory_order_acquire)) {
    if (!backoff.wait()) remaining_.wait(left, std::memory_order_acquire);
  }
  if (backoff.isLong()) ++long_waits_;
  if (parked) park();
}

void SpinTeam::wake() {
  if (size_ == 1 || (awake_.load(std::memory_order_relaxed) & 1u) != 0) return;
  awake_.fetch_add(1);
  awake_.notify_all();
}

void SpinTeam::park() {
  if (size_ == 1 || (awake_.load(std::memory_order_relaxed) & 1u) == 0) return;
  awake_.fetch_add(1);
}

void SpinTeam::waitForJob(std::uint32_t done_generation) {
  Backoff backoff;
  while (generation_.load(std::memory_order_acquire) == done_generation) {
    const std::uint32_t awake = awake_.load(std::memory_order_acquire);
    if ((awake & 1u) == 0) {
      awake_.wait(awake, std::memory_order_acquire);
      backoff = {};
    } else if (!backoff.wait()) {
      generation_.wait(done_generation, std::memory_order_acquire);
    }
  }
}

void SpinTeam::work(int member) {
  for (std::uint32_t generation = 0;; ) {
    waitForJob(generation);
    ++generation;
    if (stop_) return;
    job_(context_, member, size_);
    if (remaining_.fetch_sub(1) == 1) remaining_.notify_one();
  }
}

}  // namespace palpate

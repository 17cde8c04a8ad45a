#include "base/spin_team.h"

#include <cassert>

#if defined(__x86_64__) || defined(__i386__)
#include <immintrin.h>
#endif

namespace palpate {
namespace {

// The wait between two jobs of a tick is about a microsecond; a barrier that spins costs
// 0.15 us, one that sleeps 5 us. A longer wait means that some member has lost its core,
// and a thread that goes on spinning may be what keeps the core from it.
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

SpinTeam::SpinTeam(int thread_count)
    : size_(thread_count < 1 ? 1 : thread_count), shares_(static_cast<std::size_t>(size_)) {
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

void SpinTeam::share(int part_count, Job job, void* context) { start(part_count, false, job, context); }

void SpinTeam::run(Job job, void* context) { start(size_, true, job, context); }

void SpinTeam::start(int part_count, bool pinned, Job job, void* context) {
  assert(part_count >= 0 && part_count <= 0xffff);
  if (size_ == 1) {
    for (int part = 0; part < part_count; ++part) job(context, part, part_count);
    return;
  }
  const bool parked = (awake_.load(std::memory_order_relaxed) & 1u) == 0;
  job_ = job;
  context_ = context;
  part_count_ = part_count;
  remaining_.store(part_count, std::memory_order_relaxed);
  for (int m = 0; m < size_; ++m) {
    const auto begin = static_cast<std::uint64_t>(part_count * m / size_),
               end = static_cast<std::uint64_t>(part_count * (m + 1) / size_);
    shares_[m].word.store(std::uint64_t{pinned} << 32 | end << 16 | begin, std::memory_order_release);
  }
  generation_.fetch_add(1);  // sequentially consistent: before notify looks for sleepers
  generation_.notify_all();
  if (parked) wake();

  take(0);

  Backoff backoff;
  for (int left = remaining_.load(std::memory_order_acquire); left != 0;
       left = remaining_.load(std::memory_order_acquire)) {
    if (!backoff.wait()) remaining_.wait(left, std::memory_order_acquire);
  }
  if (backoff.isLong()) ++long_waits_;
  if (parked) park();
}

void SpinTeam::take(int member) {
  for (int k = 0; k < size_; ++k) {
    std::atomic<std::uint64_t>& word = shares_[(member + k) % size_].word;
    std::uint64_t seen = word.load(std::memory_order_acquire);
    while ((seen & 0xffff) < (seen >> 16 & 0xffff)) {
      if (k > 0 && (seen >> 32 & 1) != 0) break;
      if (!word.compare_exchange_weak(seen, seen + 1, std::memory_order_acq_rel, std::memory_order_acquire)) continue;
      job_(context_, static_cast<int>(seen & 0xffff), part_count_);
      if (remaining_.fetch_sub(1) == 1) remaining_.notify_one();
      seen = word.load(std::memory_order_acquire);
    }
  }
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
  for (std::uint32_t generation = 0;;) {
    waitForJob(generation);
    generation = generation_.load(std::memory_order_acquire);  // skips jobs that the others have finished meanwhile
    if (stop_) return;
    take(member);
  }
}

}  // namespace palpate

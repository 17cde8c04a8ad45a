#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace palpate {

/// A team of threads that run one function together many times a second. Between
/// jobs of one tick the workers spin; outside a tick (park) they sleep.
/// With one thread it calls the function directly and costs nothing.
class SpinTeam {
 public:
  using Job = void (*)(void* context, int member, int member_count);

  explicit SpinTeam(int thread_count);
  ~SpinTeam();
  SpinTeam(const SpinTeam&) = delete;
  SpinTeam& operator=(const SpinTeam&) = delete;

  int size() const { return size_; }

  /// Runs job(context, 0..size-1) on all members and returns when all are done.
  /// Called by the owner thread only. No allocation, no lock.
  void run(Job job, void* context);

  /// Wakes the workers before a tick's first run, and lets them sleep after its last.
  void wake();
  void park();

  /// Native handles of the worker threads, for scheduling class and affinity.
  std::vector<std::thread>& workers() { return workers_; }

 private:
  void work(int member);

  int size_;
  std::vector<std::thread> workers_;
  alignas(64) std::atomic<std::uint32_t> generation_{0};
  alignas(64) std::atomic<int> remaining_{0};
  alignas(64) std::atomic<std::uint32_t> awake_{0};  // futex word: odd while workers should spin
  std::atomic<bool> stop_{false};
  Job job_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace palpate

#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace palpate {

/// A team of threads that run one function together many times a second: the owner,
/// who is member 0, and size - 1 workers. Between the jobs of one tick the workers
/// spin, outside a tick (park) they sleep. All waits spin for a bounded time, then
/// yield the core, then sleep on a futex: a member that lost its core to somebody
/// else delays the others but never starves or deadlocks them.
/// With one thread it calls the function directly and costs nothing.
class SpinTeam {
 public:
  using Job = void (*)(void* context, int member, int member_count);

  /// @param thread_count  the owner included; less than 1 counts as 1
  explicit SpinTeam(int thread_count);
  ~SpinTeam();
  SpinTeam(const SpinTeam&) = delete;
  SpinTeam& operator=(const SpinTeam&) = delete;

  int size() const { return size_; }

  /// Runs job(context, member, size) once on each member and returns when all are done;
  /// what they wrote is visible to the owner, and to all members of the next job.
  /// Called by the owner thread only; the job must not throw. No allocation, no lock.
  /// A parked team is woken and parked again.
  void run(Job job, void* context);

  /// Owner: wakes the workers before a tick's first run, so that they are there when it
  /// comes; lets them sleep after its last.
  void wake();
  void park();

  /// Owner: how often so far a worker kept it waiting beyond the bounded spin (50-100 us).
  std::int64_t longWaits() const { return long_waits_; }

  /// The worker threads, for scheduling class and affinity.
  std::vector<std::thread>& workers() { return workers_; }

 private:
  void work(int member);
  void waitForJob(std::uint32_t done_generation);

  int size_;
  std::vector<std::thread> workers_;
  Job job_ = nullptr;
  void* context_ = nullptr;
  std::int64_t long_waits_ = 0;                        // the owner's own
  bool stop_ = false;                                  // written before generation_, like job_
  alignas(64) std::atomic<std::uint32_t> generation_{0};  // jobs given out so far
  alignas(64) std::atomic<std::uint32_t> awake_{0};       // odd while workers should spin
  alignas(64) std::atomic<int> remaining_{0};             // workers still at the present job
};

/// Runs each(part) for part in [0, count), every member of the team taking an even share. What the parts are must not
/// depend on the team's size where results may not.
template <class Each>
void shareOut(SpinTeam& team, int count, Each each) {
  struct Context {
    int count;
    Each& each;
  } context{count, each};
  team.run(
      [](void* c, int member, int members) {
        auto& [n, call] = *static_cast<Context*>(c);
        for (int k = n * member / members; k < n * (member + 1) / members; ++k) call(k);
      },
      &context);
}

}  // namespace palpate

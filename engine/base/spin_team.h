#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace palpate {

/// A team of threads that share out work many times a second: the owner, who is member 0, and size - 1 workers.
/// Between the jobs of one tick the workers spin, outside a tick (park) they sleep. All waits spin for a bounded time, then
/// yield the core, then sleep on a futex: a member that lost its core to somebody else never starves or deadlocks the others.
/// A job's parts are there for the taking: each member begins with its own share of them, so that it meets the data that its
/// cache knows, and then takes from the others'. So one that wakes late, or has a slow core, delays the others by no more
/// than the part that it holds; one that loses its core within a part, until it has it back.
/// With one thread it calls the function directly and costs nothing.
class SpinTeam {
 public:
  using Job = void (*)(void* context, int part, int part_count);

  /// @param thread_count  the owner included; less than 1 counts as 1
  explicit SpinTeam(int thread_count);
  ~SpinTeam();
  SpinTeam(const SpinTeam&) = delete;
  SpinTeam& operator=(const SpinTeam&) = delete;

  int size() const { return size_; }

  /// Runs job(context, part, part_count) once for each part, on whichever member, and returns when all are done;
  /// what they wrote is visible to the owner, and to all members in the next job.
  /// Called by the owner thread only; the job must not throw. No allocation, no lock.
  /// A parked team is woken and parked again.
  /// @param part_count  0 to 65535
  void share(int part_count, Job job, void* context);

  /// The same with one part for each member, taken by this member and no other.
  void run(Job job, void* context);

  /// Owner: wakes the workers before a tick's first job, so that they are there when it
  /// comes; lets them sleep after its last.
  void wake();
  void park();

  /// Owner: how often so far a worker kept it waiting beyond the bounded spin (50-100 us).
  std::int64_t longWaits() const { return long_waits_; }

  /// The worker threads, for scheduling class and affinity.
  std::vector<std::thread>& workers() { return workers_; }

 private:
  void start(int part_count, bool pinned, Job job, void* context);
  void take(int member);
  void work(int member);
  void waitForJob(std::uint32_t done_generation);

  /// What nobody has taken yet of a member's share of the present job. One word, so that who takes a part knows that it is
  /// not done, hence that the job is not, and its data stand: bits 0-15 the next part, 16-31 their end, 32 only this member
  /// may take them.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> word{0};
  };

  int size_;
  std::vector<std::thread> workers_;
  std::vector<Share> shares_;  // (size)
  // Of the present job: written while nobody holds a part, read by whoever took one.
  Job job_ = nullptr;
  void* context_ = nullptr;
  int part_count_ = 0;
  std::int64_t long_waits_ = 0;                           // the owner's own
  std::atomic<bool> stop_{false};                         // set before generation_
  alignas(64) std::atomic<std::uint32_t> generation_{0};  // jobs given out so far
  alignas(64) std::atomic<std::uint32_t> awake_{0};       // odd while workers should spin
  alignas(64) std::atomic<int> remaining_{0};             // parts of the present job that are not done
};

/// Runs each(part) for part in [0, count) on the team. What the parts are must not depend on the team's size where results
/// may not.
template <class Each>
void shareOut(SpinTeam& team, int count, Each each) {
  team.share(
      count, [](void* context, int part, int) { (*static_cast<Each*>(context))(part); }, &each);
}

}  // namespace palpate

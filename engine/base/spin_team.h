#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace palpate {

/// A team of threads that share work many times a second: the owner, who is member 0, and size - 1 workers.
/// Between the jobs of one tick the workers spin; between ticks (park) they sleep. Every wait spins for a bounded time,
/// then yields the core, then sleeps on a futex, so a member that has lost its core can't starve or deadlock the
/// others. No thread takes a lock. A worker that goes to sleep, and the owner who wakes it, make a system call (futex).
/// Each member begins with the parts of a job that are its own, whose data are in its cache, and then takes parts that
/// others have not begun. A member that wakes late or has a slow core therefore delays the others by at most the one
/// part that it works on; one that loses its core within a part delays them until it has the core back.
/// With one thread the job is called directly.
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

  /// Owner: wake() before a tick's first job, so that the workers are awake when it comes;
  /// park() after its last, so that they sleep.
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

  /// The parts of the present job that belong to one member and that nobody has taken yet.
  ///   bits 0-15   the next part to take
  ///   bits 16-31  one past the last part
  ///   bit  32     set: only this member may take them
  /// All in one word, so that a part is taken by a single compare-and-exchange. Whoever succeeds holds a part that is
  /// not done; so the job is not done either, and job_, context_ and part_count_ can't change under it.
  struct alignas(64) Share {
    std::atomic<std::uint64_t> word{0};
  };

  int size_;
  std::vector<std::thread> workers_;
  std::vector<Share> shares_;  // (size)
  // The present job. Written only while no member holds a part; read only by members that hold one.
  Job job_ = nullptr;
  void* context_ = nullptr;
  int part_count_ = 0;
  std::int64_t long_waits_ = 0;                           // read and written by the owner only
  std::atomic<bool> stop_{false};                         // written before the generation_ that shows it
  alignas(64) std::atomic<std::uint32_t> generation_{0};  // jobs started so far
  alignas(64) std::atomic<std::uint32_t> awake_{0};       // odd while workers should spin
  alignas(64) std::atomic<int> remaining_{0};             // parts of the present job that are not done
};

/// Runs each(part) for part in [0, count) on the team. Where results must not depend on the team's size, neither may
/// the division into parts.
template <class Each>
void shareOut(SpinTeam& team, int count, Each each) {
  team.share(
      count, [](void* context, int part, int) { (*static_cast<Each*>(context))(part); }, &each);
}

/// Runs each(part, begin, end) on the team for `parts` equal parts of rows [0, count), the same whatever the team.
template <class Index, class Each>
void shareRows(SpinTeam& team, int parts, Index count, Each each) {
  const auto border = [=](int part) { return static_cast<Index>(static_cast<std::int64_t>(count) * part / parts); };
  shareOut(team, parts, [&](int part) { each(part, border(part), border(part + 1)); });
}

}  // namespace palpate

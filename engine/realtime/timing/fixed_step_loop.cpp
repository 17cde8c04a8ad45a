#include "realtime/timing/fixed_step_loop.h"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>

#include "realtime/timing/catch_up.h"

namespace palpate {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;

/// Grid times start + k / rate, from k itself: no drift.
struct Grid {
  std::int64_t start;
  double period;  // ns

  std::int64_t at(std::int64_t k) const { return start + std::llround(static_cast<double>(k) * period); }
  /// The first grid index whose time is not before `time`, and not below `least`.
  std::int64_t firstNotBefore(std::int64_t time, std::int64_t least) const {
    auto k = static_cast<std::int64_t>(std::floor(static_cast<double>(time - start) / period));
    k = std::max(k, least);
    while (at(k) < time) ++k;
    return k;
  }
};

/// Simulated against wall time, in stretches between pauses.
class Progress {
 public:
  explicit Progress(double period_ns) : period_(period_ns) {}

  void advanced(std::int64_t begin, std::int64_t end, LoopTime& time) {
    if (!running_) {
      running_ = true;
      stretch_begin_ = window_begin_ = begin;
      stretch_ticks_ = window_ticks_ = 0;
      first_window_ = true;
    }
    ++ticks_;
    ++stretch_ticks_;
    ++window_ticks_;
    stretch_end_ = end;
    time.realtime_factor = factor(stretch_ticks_, end - stretch_begin_);
    if (first_window_) time.recent_realtime_factor = time.realtime_factor;
    if (end - window_begin_ >= kNsPerSecond) {
      time.recent_realtime_factor = factor(window_ticks_, end - window_begin_);
      window_begin_ = end;
      window_ticks_ = 0;
      first_window_ = false;
    }
  }

  void paused() {
    if (!running_) return;
    running_ = false;
    wall_ += stretch_end_ - stretch_begin_;
  }

  LoopTotals totals() {
    paused();
    LoopTotals totals;
    totals.simulated_seconds = 1e-9 * period_ * static_cast<double>(ticks_);
    totals.wall_seconds = 1e-9 * static_cast<double>(wall_);
    totals.realtime_factor = factor(ticks_, wall_);
    return totals;
  }

 private:
  double factor(std::int64_t ticks, std::int64_t wall) const {
    return wall > 0 ? period_ * static_cast<double>(ticks) / static_cast<double>(wall) : 1.0;
  }

  double period_;
  bool running_ = false;
  bool first_window_ = true;
  std::int64_t ticks_ = 0, wall_ = 0;
  std::int64_t stretch_ticks_ = 0, stretch_begin_ = 0, stretch_end_ = 0;
  std::int64_t window_ticks_ = 0, window_begin_ = 0;
};

void increase(std::atomic<std::int64_t>& counter, std::int64_t by) {  // one writer
  counter.store(counter.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
}

void raise(std::atomic<std::int64_t>& largest, std::int64_t value) {  // one writer
  if (value > largest.load(std::memory_order_relaxed)) largest.store(value, std::memory_order_relaxed);
}

}  // namespace

std::int64_t MonotonicClock::now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kNsPerSecond + t.tv_nsec;
}

void MonotonicClock::sleepUntil(std::int64_t time) {
  const timespec t{time / kNsPerSecond, time % kNsPerSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

std::int64_t MonotonicClock::threadCpu() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec * kNsPerSecond + t.tv_nsec;
}

ThreadUse MonotonicClock::threadUse() {
  rusage use{};
  getrusage(RUSAGE_THREAD, &use);
  return {use.ru_nivcsw, use.ru_minflt + use.ru_majflt};
}

LoopTotals runFixedStepLoop(const FixedStepOptions& options, Clock& clock, LoopBody& body,
                            DeadlineStatistics& statistics) {
  const Grid grid{clock.now(), static_cast<double>(kNsPerSecond) / options.rate_hz};
  const auto period = std::llround(grid.period);
  const bool fast = options.as_fast_as_possible;
  Progress progress(grid.period);
  CatchUp catch_up(options.catch_up);
  LoopTime time;
  std::int64_t k = 0;                                      // grid index of the present tick
  std::int64_t cpu = fast ? 0 : clock.threadCpu();         // before the sleep
  ThreadUse use = fast ? ThreadUse{} : clock.threadUse();  // at the last late tick or in a pause
  for (;;) {
    const bool made_good = catch_up.owes();  // this tick, whose grid time has gone by
    if (!fast && !made_good) clock.sleepUntil(grid.at(k));
    const std::int64_t begin = time.begin_ns = clock.now(), waited = body.waited();
    const TickOutcome outcome = body.onTick(time);
    const std::int64_t end = clock.now();

    if (outcome == TickOutcome::Stop) return progress.totals();
    if (outcome == TickOutcome::Idle) {
      progress.paused();
      catch_up.paused();
      k = grid.firstNotBefore(end, k + 1);
      if (fast) {
        clock.sleepUntil(grid.at(k));  // nothing to hurry for
        continue;
      }
      // What the pause took must not be charged to the tick that comes after it.
      cpu = clock.threadCpu();
      use = clock.threadUse();
      continue;
    }

    statistics.step.add(end - begin - (body.waited() - waited));
    increase(statistics.ticks, 1);
    if (fast) {
      progress.advanced(begin, end, time);
      continue;
    }
    if (!made_good) statistics.wakeup_late.add(begin - grid.at(k));
    const std::int64_t next = grid.firstNotBefore(end, k + 1);
    const CatchUp::Outcome lost = catch_up.tickEnded(next - (k + 1));
    increase(statistics.overrun_count, lost.missed);
    increase(statistics.caught_up_count, made_good ? 1 : 0);
    raise(statistics.longest_overrun_streak, catch_up.streak());
    progress.advanced(grid.at(k), grid.at(next), time);
    const std::int64_t cpu_before = std::exchange(cpu, clock.threadCpu());
    // A tick that follows at once begins late by intent: it counts as late where it alone took too long.
    const bool late_itself = lost.missed > 0 && (!made_good || end - begin > period);
    if (late_itself || lost.skipped > 0) {
      const ThreadUse use_before = std::exchange(use, clock.threadUse());
      LateTick late;
      late.period_ns = period;
      late.late_ns = made_good ? 0 : begin - grid.at(k);
      late.step_ns = end - begin;
      late.computing_ns = cpu - cpu_before;
      late.missed = lost.missed;
      late.skipped = lost.skipped;
      late.involuntary_switches = use.involuntary_switches - use_before.involuntary_switches;
      late.page_faults = use.page_faults - use_before.page_faults;
      body.onLate(late, time);
    }
    k += 1 + lost.skipped;
  }
}

}  // namespace palpate

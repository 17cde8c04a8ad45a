#pragma once

#include <cstdint>

#include "realtime/timing/deadline_statistics.h"
#include "realtime/timing/overload.h"

namespace palpate {

/// What the calling thread has gone through since it began.
struct ThreadUse {
  std::int64_t involuntary_switches = 0;
  std::int64_t page_faults = 0;
};

/// Time as the loop sees it. The real one is MonotonicClock; tests put theirs here.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now() = 0;                  // ns
  virtual void sleepUntil(std::int64_t time) = 0;  // ns, absolute
  virtual std::int64_t threadCpu() = 0;            // ns that the calling thread has been running
  virtual ThreadUse threadUse() = 0;
};

/// CLOCK_MONOTONIC; sleeps with clock_nanosleep(TIMER_ABSTIME). now() does not enter the kernel, the
/// others do.
class MonotonicClock final : public Clock {
 public:
  std::int64_t now() override;
  void sleepUntil(std::int64_t time) override;
  std::int64_t threadCpu() override;  // CLOCK_THREAD_CPUTIME_ID
  ThreadUse threadUse() override;     // getrusage(RUSAGE_THREAD)
};

/// What one call of a loop's body did.
enum class TickOutcome {
  Advanced,  // a tick of simulated time
  Idle,      // nothing (paused): time stands, nothing is counted
  Stop,      // nothing, and the loop ends
};

/// How the loop stands when a body is called.
struct LoopTime {
  std::int64_t begin_ns = 0;          // now, by the loop's clock
  double realtime_factor = 1;         // simulated / wall time since start or last resume
  double recent_realtime_factor = 1;  // over about the last second
};

/// What the loop calls once a period.
class LoopBody {
 public:
  virtual ~LoopBody() = default;
  virtual TickOutcome onTick(const LoopTime& time) = 0;
  /// ns, that onTick has waited for others in all: no computation, and in no duration of steps.
  virtual std::int64_t waited() const { return 0; }
  /// After a tick that was not done at the next grid time; all but LateTick::tick and long_waits is known.
  virtual void onLate(const LateTick&, const LoopTime&) {}
};

struct FixedStepOptions {
  double rate_hz = 500;
  bool as_fast_as_possible = false;  // no sleep, no deadlines
  int catch_up = 0;                  // late ticks that are made good (CatchUp); 0: missed grid times are skipped
};

/// Totals of a loop that has ended.
struct LoopTotals {
  double simulated_seconds = 0;
  double wall_seconds = 0;     // while time ran: pauses are left out
  double realtime_factor = 1;  // simulated / wall
};

/// Calls `body` at the fixed rate until it says Stop. Deadlines are absolute, start +
/// k / rate, computed from k and so free of drift. A tick that isn't done at the next
/// grid time has missed it: the missed times are counted. Up to `catch_up` of them are
/// made good: their ticks follow at once, without a sleep (catch_up.h). The others are
/// skipped whole, so the phase is kept, simulated time falls behind, and the step never
/// stretches. The ticks are the same in either case, bit for bit.
/// Real-time: no allocation, no lock, no throw. System calls: the sleep; before each sleep, where it
/// delays no tick, a look at the thread's own CPU clock, which later tells whether a late tick computed
/// or had lost its core; getrusage after late ticks and in a pause.
LoopTotals runFixedStepLoop(const FixedStepOptions& options, Clock& clock, LoopBody& body,
                            DeadlineStatistics& statistics);

}  // namespace palpate

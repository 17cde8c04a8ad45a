#pragma once

#include <cstdint>

#include "realtime/deadline_statistics.h"

namespace palpate {

/// Time as the loop sees it. The real one is MonotonicClock; tests put theirs here.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual std::int64_t now() = 0;                    // ns
  virtual void sleepUntil(std::int64_t time) = 0;    // ns, absolute
};

/// CLOCK_MONOTONIC; sleeps with clock_nanosleep(TIMER_ABSTIME).
class MonotonicClock final : public Clock {
 public:
  std::int64_t now() override;
  void sleepUntil(std::int64_t time) override;
};

/// What one call of a loop's body did.
enum class TickOutcome {
  Advanced,  // a tick of simulated time
  Idle,      // nothing (paused): time stands, nothing is counted
  Stop,      // nothing, and the loop ends
};

/// How the loop stands when a body is called.
struct LoopTime {
  std::int64_t last_step_ns = 0;      // computing time of the last tick that advanced
  double realtime_factor = 1;         // simulated / wall time since start or last resume
  double recent_realtime_factor = 1;  // over about the last second
};

/// What the loop calls once a period.
class LoopBody {
 public:
  virtual ~LoopBody() = default;
  virtual TickOutcome onTick(const LoopTime& time) = 0;
};

struct FixedStepOptions {
  double rate_hz = 500;
  bool as_fast_as_possible = false;  // no sleep, no deadlines
};

/// Totals of a loop that has ended.
struct LoopTotals {
  double simulated_seconds = 0;
  double wall_seconds = 0;           // while time ran: pauses are left out
  double realtime_factor = 1;        // simulated / wall
};

/// Calls `body` at the fixed rate until it says Stop. Deadlines are absolute, start +
/// k / rate, computed from k and so free of drift. A tick that isn't done at the next
/// grid time has missed it: the missed times are counted and skipped whole, so the
/// phase is kept, simulated time falls behind, and the step never stretches.
/// Real-time: no allocation, no lock, no throw, no system call but the sleep.
LoopTotals runFixedStepLoop(const FixedStepOptions& options, Clock& clock, LoopBody& body,
                            DeadlineStatistics& statistics);

}  // namespace palpate

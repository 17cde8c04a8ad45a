#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace palpate {

/// Why a tick missed its deadline, as far as can be measured.
enum class LateCause : std::uint8_t {
  LateWakeUp,       // it began late, and that cost the deadline
  CoreTaken,        // it began in time, but for part of it the thread was not running
  WorkerLate,       // the thread waited for a worker of its team
  LongComputation,  // it computed too long to be in time
};
inline constexpr std::size_t kLateCauseCount = 4;

/// What was measured of a tick that was not done at the next grid time.
struct LateTick {
  std::int64_t tick = 0;  // of the run
  std::int64_t period_ns = 0;
  std::int64_t late_ns = 0;               // its begin after its grid time
  std::int64_t step_ns = 0;               // wall time from begin to end
  std::int64_t computing_ns = 0;          // CPU time of the loop's thread since the tick or pause before
  std::int64_t missed = 0;                // grid times that went by before it was done
  std::int64_t skipped = 0;               // grid times, then, whose ticks will not be made good
  std::int64_t long_waits = 0;            // times in it that a worker kept the loop's thread waiting
  std::int64_t involuntary_switches = 0;  // of the loop's thread since the late tick or pause before
  std::int64_t page_faults = 0;           // likewise
};

LateCause causeOf(const LateTick& tick);

/// A spell of late ticks, each soon after the one before.
struct Overload {
  std::int64_t late_ticks = 0;
  std::int64_t missed = 0;                               // grid times gone by in late ticks
  std::int64_t skipped = 0;                              // grid times that were not made good
  std::array<std::int64_t, kLateCauseCount> by_cause{};  // late ticks
  std::int64_t first_tick = 0;
  double seconds = 0;  // wall time from the first late tick to the last
  LateTick worst;      // the one in which most grid times went by

  void add(const LateTick& tick);
};

/// "tick 4711 took 14.2 ms, 1.1 of them computing: its core was taken (3 involuntary switches)".
/// Allocates: not for the loop thread.
std::string lateTickText(const LateTick& tick);

/// "57 late ticks in 3.2 s (40 woken late, 17 core taken), 310 periods skipped; the worst: tick 4711 ..."
std::string overloadText(const Overload& overload);

}  // namespace palpate

#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "realtime/timing/overload.h"

namespace palpate {

/// Percentiles of a duration, us.
struct Percentiles {
  double p50 = 0, p99 = 0, p999 = 0, max = 0;
};

/// Histogram of durations with fixed memory (16 kB) and a fixed relative error.
/// Each octave of nanoseconds is divided in 64 equal bins, so a bin is at most 1/64
/// of its value wide and its middle at most 0.8 % off; below 64 ns it is exact, above
/// 68 s all goes into the last bin. The maximum is kept exactly.
/// One thread adds; any thread may read at any time (counts are relaxed atomics).
class DurationHistogram {
 public:
  static constexpr int kSubBits = 6;   // 64 bins per octave
  static constexpr int kOctaves = 30;  // 2^6 ns .. 2^36 ns
  static constexpr int kBinCount = (kOctaves + 1) << kSubBits;

  /// Real-time: no allocation, no lock, no throw. Negative durations count as 0.
  void add(std::int64_t ns);

  std::int64_t count() const { return count_.load(std::memory_order_relaxed); }
  double maxUs() const { return static_cast<double>(max_ns_.load(std::memory_order_relaxed)) * 1e-3; }

  /// The smallest duration that a share `p` (0..1] of all does not exceed, us; within 0.8 %.
  double percentileUs(double p) const;
  Percentiles percentiles() const;

  /// For plots: count and limits of bin `b`, us.
  std::int64_t binCount(int b) const { return bins_[static_cast<std::size_t>(b)].load(std::memory_order_relaxed); }
  static double binBeginUs(int b);
  static double binEndUs(int b) { return binBeginUs(b + 1); }
  static int binOf(std::int64_t ns);

 private:
  std::array<std::atomic<std::int64_t>, kBinCount> bins_{};
  std::atomic<std::int64_t> count_{0};
  std::atomic<std::int64_t> max_ns_{0};
};

/// How the loop kept its deadlines. Written by the loop thread, readable from any.
///
/// Tick k of the grid should start at start + k * period and be done before the next
/// grid time. Each grid time at which the loop was still busy (or asleep) is a missed
/// deadline and counted. Its tick is then made good, late, and counted again
/// (caught_up_count), or it is skipped and never run. So
/// ticks + overrun_count - caught_up_count = periods gone by, but for the few ticks that
/// are owed at the moment, and realtime_factor = ticks / periods.
struct DeadlineStatistics {
  DurationHistogram step;         // computing time of a tick
  DurationHistogram wakeup_late;  // start of a tick after its deadline; not of ticks that are made good
  std::atomic<std::int64_t> ticks{0};
  std::atomic<std::int64_t> overrun_count{0};
  std::atomic<std::int64_t> caught_up_count{0};         // ticks that were made good
  std::atomic<std::int64_t> longest_overrun_streak{0};  // most deadlines missed between two ticks that were on time
  std::array<std::atomic<std::int64_t>, kLateCauseCount>
      late_ticks{};  // ticks that were late by themselves, by LateCause
};

}  // namespace palpate

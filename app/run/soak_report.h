#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/run/soak_motion.h"
#include "realtime/loop/run_summary.h"
#include "realtime/timing/deadline_statistics.h"
#include "realtime/timing/resource_use.h"

namespace palpate::app {

/// A bar of a histogram: so many durations from begin_us to end_us.
struct HistogramBar {
  double begin_us = 0, end_us = 0;
  std::int64_t count = 0;
};

/// The histogram in quarter octaves, from its first bar that is not empty to its last.
std::vector<HistogramBar> barsOf(const DurationHistogram& histogram);

/// A physics thread since the end of the warm-up.
struct SoakThread {
  int id = 0;  // the kernel's
  ThreadCounters counters;
};

/// How a long run went so far.
struct SoakReport {
  std::string scene, state;  // "running", "done", "interrupted"
  double minutes = 0;        // asked for, of physics time
  double physics_seconds = 0, wall_seconds = 0;
  double realtime_factor = 0, recent_realtime_factor = 0;
  std::int64_t ticks = 0, overruns = 0, caught_up = 0, longest_overrun_streak = 0;
  std::array<std::int64_t, kLateCauseCount> late_ticks{};  // by LateCause
  Percentiles step_us, wakeup_late_us;
  std::vector<HistogramBar> step_bars, wakeup_late_bars;

  std::int64_t cycles = 0;           // that have ended
  std::int64_t unrested_cycles = 0;  // the tissue was still moving after RestWatch::longest_rest_s
  double unrested_speed = 0;         // m/s, the most of a node at the end of one of these
  double longest_rest_s = 0;
  double organ_size_m = 0;
  double drift_m = 0;          // of the last rest from the first
  double largest_drift_m = 0;  // of all rests from the first
  double peak_force_N = 0;
  float min_J = 1;
  std::uint32_t flags = 0;  // StepFlag, all ticks
  bool rough = false;       // a rough hand: restores are bounded (RoughLimits); a careful one needs none
  unsigned seed = 1;
  bool frozen = false;
  std::int64_t restored = 0;  // times that the tissue was lost and went back to an earlier state
  Restores restores;          // the same by cause; known at the end
  std::int64_t let_go = 0;    // times that a tool was stuck, and let the tissue go; likewise
  // Of the skin with itself (SkinCrossings), the most at a time: while no tool touched it, and of that at rest.
  int crossings = 0, crossings_at_rest = 0;
  std::int64_t not_finite = 0;  // ticks with a number that was not finite
  double largest_yield_m = 0;   // that the tool stayed behind the hand; known at the end

  std::optional<MemoryUse> warm;  // at the end of the warm-up, if that has come
  double warm_physics_seconds = 0;
  MemoryUse memory;                 // at present
  std::vector<SoakThread> threads;  // since the end of the warm-up

  /// Largest distance of the last rest from the first, relative to the organ's size.
  double drift() const { return organ_size_m > 0 ? drift_m / organ_size_m : 0; }
  std::int64_t memory_play = 0;  // bytes by which memory may change
  /// Bytes of heap and stacks since the end of the warm-up.
  std::int64_t memoryGrowth() const { return warm ? memory.anonymous - warm->anonymous : 0; }
};

/// What a rough hand may do to the tissue, as bad as it was measured to be over the scenes of assets and coarse copies
/// of them: times in 10^6 ticks that it is put back, or that a tool lets it go (in a run of any length so many in
/// proportion, and one more, since they come by chance), and places where its skin crosses itself.
struct RoughLimits {
  static constexpr double lost = 10, folded = 60, let_go = 30;
  static constexpr int crossings = 1200, crossings_at_rest = 0;
};

/// Takes a cycle into the sums.
void addCycle(SoakReport& report, const SoakCycle& cycle);

/// What a long run must keep, and this one did not; empty: all kept. Memory does not grow after the
/// warm-up, rests drift by less than RestWatch::drift_limit, the tissue comes to rest, all stays finite; under a rough
/// hand rests may differ by RestWatch::rough_drift_limit_m, and the tissue may be put back as seldom as RoughLimits
/// say.
std::vector<std::string> brokenPromises(const SoakReport& report);

/// Of a cycle after which the tissue did not come to rest.
std::string unrestedLine(const SoakCycle& cycle);

/// "12.0 min: 240 cycles, real time x1.0000, step p99.9 812 us, 3 overruns, drift 2.1e-09, memory +0 kB"
std::string soakLine(const SoakReport& report);

/// soak.json: keys as the members, and what of the promises is broken.
std::string toJson(const SoakReport& report);

/// soak.txt: the same for people, with histograms.
std::string toText(const SoakReport& report);

}  // namespace palpate::app

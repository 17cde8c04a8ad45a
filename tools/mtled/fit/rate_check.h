#pragma once

#include "mtled/run/scripted_run.h"
#include "realtime/timing/deadline_statistics.h"

namespace palpate::tools {

/// How a model kept its rate in the real-time loop, no picture beside it.
struct HeldRate {
  Percentiles step_us;
  std::int64_t ticks = 0, overruns = 0;
  double realtime_factor = 0;
  bool frozen = false;  // the watchdog stopped it

  /// Less than 0.1 % of the periods missed, and 99.9 % of the ticks computed within one.
  bool held(double rate_hz) const;
};

/// Runs the way over and over in the real-time loop, as `palpate` does.
/// @param seconds  of wall time, at least
HeldRate checkRate(Scene scene, const ToolTrajectory& way, int threads, double seconds);

}  // namespace palpate::tools

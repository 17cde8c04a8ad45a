#pragma once

#include <cstdint>

#include "realtime/channels/log_event.h"
#include "realtime/timing/overload.h"

namespace palpate {

/// Logs late ticks without flooding the log. The first is logged at once. Those that follow are summed
/// up in one line when no tick has been late for quiet_seconds, or every line_seconds while the overload
/// goes on. A new overload is logged only when line_seconds have gone by since the last line. So there
/// are at most two lines in line_seconds, and every late tick is counted in one.
/// Real-time: no allocation, no lock, no throw.
class OverloadWatch {
 public:
  static constexpr double quiet_seconds = 1;  // wall time
  static constexpr double line_seconds = 60;  // wall time

  explicit OverloadWatch(double rate_hz) : rate_hz_(rate_hz) {}

  /// @param now  ns, wall clock
  void add(const LateTick& tick, std::int64_t now, LogRing& log);

  /// Each tick: logs the summary that is due, if any.
  /// @param tick  of the run
  void update(std::int64_t now, std::int64_t tick, LogRing& log);

  /// At the end of the run: logs what has not been logged.
  void end(std::int64_t tick, LogRing& log);

 private:
  void logEvent(LogEvent::Kind kind, std::int64_t tick, LogRing& log);
  bool lineIsDue(std::int64_t now) const;

  double rate_hz_;
  bool open_ = false;        // an overload is being watched
  bool first_told_ = false;  // its first tick was logged at once
  Overload overload_;
  std::int64_t told_ticks_ = 0;                  // of overload_.late_ticks
  std::int64_t first_late_ = 0, last_late_ = 0;  // ns
  bool any_line_ = false;
  std::int64_t last_line_ = 0;  // ns
};

}  // namespace palpate

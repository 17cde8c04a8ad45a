#pragma once

#include <array>
#include <cstdint>

#include "realtime/channels/log_event.h"
#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// When the watchdog freezes the tissue.
struct WatchdogLimits {
  // One or two points that are inverted under a hard poke recover; many do not.
  double flood_fraction = 0.02;  // of the integration points (at least flood_minimum)
  int flood_minimum = 8;
  int flood_ticks = 25;         // in a row with that many: freeze
  double flood_at_once = 0.20;  // of the integration points: freeze in the first tick
};

/// Judges each tick's report: go on, warn, or freeze. A warning is logged when its
/// condition begins, and again only after the condition has been absent for a second.
/// Real-time: no allocation, no lock, no throw.
class Watchdog {
 public:
  explicit Watchdog(const Model& model, const WatchdogLimits& limits = {});

  /// @param tick  of the run; goes into the events
  /// @return true where the tissue must be frozen; then log holds a freeze event that
  ///         names the place
  bool judge(const StepReport& report, std::int64_t tick, LogRing& log);

  void reset();

 private:
  static constexpr std::size_t kWarningCount = 4;
  static constexpr std::int64_t kNever = -1;
  bool begins(int warning, bool condition, std::int64_t tick);

  const Model& model_;
  WatchdogLimits limits_;
  int inverted_ticks_ = 0;
  std::array<std::int64_t, kWarningCount> last_seen_{};  // tick of each warning's condition
};

}  // namespace palpate

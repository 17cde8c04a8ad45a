#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "model/model.h"
#include "model/state.h"
#include "realtime/channels/log_event.h"

namespace palpate {

/// What the watchdog wants after a tick.
enum class Verdict : std::uint8_t {
  Good,
  Restore,  // the solution is lost: back to an earlier state
  Freeze,   // it has been lost too often of late
};

/// Judges each tick's report: go on, warn, restore what is not finite or blew up (CompressionLimit keeps points from
/// turning inside out; those that do are doubted), or freeze: where the solution has been lost and restored three times
/// within a second of physics time, the fourth loss freezes the tissue. A warning is logged when its condition begins,
/// and again only after the condition has been absent for a second.
/// Real-time: no allocation, no lock, no throw.
class Watchdog {
 public:
  explicit Watchdog(const Model& model);

  /// @param tick  of the run; goes into the events
  /// Where the verdict is not Good, log holds an event that names cause and place.
  Verdict judge(const StepReport& report, std::int64_t tick, LogRing& log);

  /// How often the solution was lost within the last second before the present loss: how far to go back.
  int recentLosses() const { return recent_losses_; }

  void reset();
  /// The body has other nodes.
  void goOnWith(const Model& model) { model_ = &model; }

 private:
  static constexpr std::size_t kWarningCount = 4;
  static constexpr std::int64_t kNever = -1;
  bool begins(int warning, bool condition, std::int64_t tick);
  Verdict lost(std::int64_t tick);

  const Model* model_;
  std::array<std::int64_t, 3> losses_{};  // ticks of the last, as a ring
  std::size_t next_loss_ = 0;
  int recent_losses_ = 0;
  std::array<std::int64_t, kWarningCount> last_seen_{};  // tick of each warning's condition
};

}  // namespace palpate

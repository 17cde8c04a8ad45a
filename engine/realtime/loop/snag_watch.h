#pragma once

#include <cstdint>

#include "simulation/model.h"
#include "simulation/state.h"

namespace palpate {

/// Finds a tool that has carried tissue off: with the hand far outside the body's shape at rest, and itself outside, it
/// is still touched (it may stay behind a hand that draws harder than the tissue bears). A hand rough
/// enough can push a fold over the tool that holds it like a glove, however far it is drawn out; skin knows no contact
/// with itself, which would have kept the fold open.
///
/// Jaws and further tools may hold tissue, and boundaries that move may carry it: there nothing is found.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/snag_watch_test.cpp
class SnagWatch {
 public:
  static constexpr double seconds = 0.5;       // so long
  static constexpr double far_outside = 0.25;  // of the diagonal of the skin's box at rest, beside the tool's own size

  explicit SnagWatch(const Model& model);

  /// A tick has ended well. @param hand  m, where the tool's tip would be without tissue
  /// @return whether the tool is caught; then the watch begins anew
  bool update(const State& state, const Vec3& hand, const StepReport& report);

  /// Ticks in which the tool was touched since the hand is far outside: what its coming verdicts depend on.
  std::int64_t memory() const { return ticks_; }
  void recall(std::int64_t ticks) { ticks_ = ticks; }

 private:
  bool isBeyond(const Vec3& tip, double distance) const;

  bool off_ = false;           // carrying is what this scene is for
  Vec3 low_, high_;            // m, the skin's box at rest
  double near_, far_;          // m, from it: no part of the tool is in it; the hand has left
  const std::int64_t needed_;  // ticks
  std::int64_t ticks_ = 0;
};

}  // namespace palpate

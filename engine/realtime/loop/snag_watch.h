#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/state.h"

namespace palpate {

/// Finds a tool that is caught in the tissue, in one of two ways, out of which no hand that goes on draws it. A hand
/// rough enough can push a fold over the tool that holds it like a glove.
///
/// It has carried tissue off: with the hand far outside the body's shape at rest, and itself outside, it is still
/// touched (it may stay behind a hand that draws harder than the tissue bears).
///
/// It is stuck: with the hand far outside the tool stands still for long, held by skin before it and behind. A tool
/// that presses, however long and however far beneath the body its hand is, is pushed back by what is before it.
///
/// A body that nothing holds along some axis may be pushed anywhere there: its shape at rest goes along. Jaws hold
/// tissue, and boundaries that move may carry it: nothing is found for jaws, or where a boundary is moved.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/snag_watch_test.cpp
class SnagWatch {
 public:
  static constexpr double seconds = 0.5;       // so long it is carried off
  static constexpr double far_outside = 0.25;  // of the diagonal of the skin's box at rest, beside the tool's own size
  static constexpr double stuck_seconds = 5;   // so long it is stuck
  static constexpr double stands = 0.25;       // of the tool's radius: within that it stands still
  // Of the contact's forces along the way to the hand, those to both sides: with a net push below this it is stuck.
  static constexpr double between = 0.55;

  /// @param tool  that it looks at
  explicit SnagWatch(const Model& model, int tool = 0);

  /// Before a tick. @param hand  m, where the tool's tip would be without tissue
  /// @param last  the tick before's outcome
  /// @return whether the tool is caught; then the watch begins anew
  bool update(const State& state, const Vec3& hand, const StepReport& last);

  /// No part of the tool is in the body's shape at rest, or near its skin as it is.
  bool isClear(const State& state, const StepReport& last) const;

  /// What its coming verdicts depend on.
  struct Memory {
    std::int64_t carried_ticks = 0;  // in which the tool was touched since the hand is far outside
    std::int64_t stuck_ticks = 0;    // that it stands between skin,
    Vec3 stood_at = Vec3::Zero();    // m, here
  };
  const Memory& memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

 private:
  bool isBeyond(const State& state, const Vec3& tip, double distance) const;
  bool isBetween(const State& state, const Vec3& way) const;
  bool isCarrying(const State& state, const Vec3& hand, bool touches);
  bool isStuck(const State& state, const Vec3& hand, bool touches);

  const Model& model_;
  const std::size_t tool_;
  bool off_ = false;                                  // carrying is what this tool or scene is for
  Vec3 free_;                                         // 1 along the axes along which the body can slide
  Vec3 low_, high_;                                   // m, the skin's box at rest
  double near_, far_;                                 // m, from it: no part of the tool is in it; the hand has left
  double still_;                                      // m
  const std::int64_t carried_needed_, stuck_needed_;  // ticks
  Memory memory_;
};

}  // namespace palpate

#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/state.h"

namespace palpate {

/// Finds a tool that is stuck in the tissue: a hand rough enough can push a fold over the tool that holds it like a
/// glove. Far from its hand the tool stands still for long, held by skin before it and behind. One that presses, or
/// lifts what hangs on it, however long and however far from its hand, is pushed back by what is before it. What jaws
/// hold they hold on purpose.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/snag_watch_test.cpp
class SnagWatch {
 public:
  static constexpr double seconds = 5;    // so long
  static constexpr double far = 0.25;     // of the diagonal of the skin's box at rest: beyond that its hand is far
  static constexpr double stands = 0.25;  // of the tool's radius: within that it stands still
  // Of the contact's forces along the way to the hand, those to both sides: with a net push below this it is stuck.
  static constexpr double between = 0.55;

  /// @param tool  that it looks at
  explicit SnagWatch(const Model& model, int tool = 0);

  /// Before a tick. @param hand  m, where the tool's tip would be without tissue
  /// @return whether the tool is stuck; then the watch begins anew
  bool update(const State& state, const Vec3& hand);

  /// What its coming verdicts depend on.
  struct Memory {
    std::int64_t ticks = 0;        // that it stands between skin,
    Vec3 stood_at = Vec3::Zero();  // m, here
  };
  const Memory& memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

 private:
  bool isBetween(const State& state, const Vec3& way) const;

  const Model& model_;
  const std::size_t tool_;
  double far_;                 // m
  double still_;               // m
  const std::int64_t needed_;  // ticks
  Memory memory_;
};

}  // namespace palpate

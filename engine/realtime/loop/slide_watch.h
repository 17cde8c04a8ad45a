#pragma once

#include <cstdint>

#include "simulation/model.h"
#include "simulation/report.h"
#include "simulation/state.h"

namespace palpate {

/// Finds a body that has slid away: one that nothing holds along some axis may rest anywhere there, and a rough hand
/// flicks it off, out of the tools' reach and out of the picture, where its coordinates are coarser, too. Nothing touches
/// or pulls it, and it is further from its place than it is large.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/slide_watch_test.cpp
class SlideWatch {
 public:
  static constexpr double seconds = 0.5;  // so long
  static constexpr double away = 1;       // diagonal of the body's box at rest: so far

  explicit SlideWatch(const Model& model);

  /// What its coming verdicts depend on.
  struct Memory {
    std::int64_t ticks = 0;  // that it is away and alone
  };
  Memory memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

  /// A tick has ended well. @param pulled  a spring pulls the skin
  /// @return whether the body has slid away; then the watch begins anew
  bool update(const State& state, const StepReport& report, bool pulled);

 private:
  const std::int64_t needed_;  // ticks
  Vec3 free_;                  // 1 along the axes along which it can slide
  double far_ = 0;             // m
  Memory memory_;
};

}  // namespace palpate

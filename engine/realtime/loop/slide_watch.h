#pragma once

#include <cstdint>

#include "model/model.h"
#include "model/report.h"
#include "model/state.h"

namespace palpate {

/// Finds a body that has left its place: one that nothing holds along some axis may rest anywhere there, and a rough
/// hand flicks it off, out of the tools' reach and out of the picture, where its coordinates are coarser, too; or turns
/// it over, where it lies beneath what it stood on, as free of strain. Nothing touches or pulls it, and it is further
/// from its place than it is large, or turned by more than a right angle.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/slide_watch_test.cpp
class SlideWatch {
 public:
  static constexpr double seconds = 0.5;  // so long it has to be alone each time it is looked at
  static constexpr double away = 1;       // diagonal of the body's box at rest: so far

  explicit SlideWatch(const Model& model);

  /// The body has other nodes.
  void goOnWith(const Model& model) { model_ = &model; }

  /// What its coming verdicts depend on.
  struct Memory {
    std::int64_t ticks = 0;  // that it is alone, since it was looked at
  };
  Memory memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

  /// A tick has ended well. @param pulled  a spring pulls the skin
  /// @return whether the body has slid away or turned over
  bool update(const State& state, const StepReport& report, bool pulled);

 private:
  bool hasLeft(const State& state) const;

  const std::int64_t needed_;  // ticks
  Vec3 free_;                  // 1 along the axes along which it can slide
  double far_ = 0;             // m
  const Model* model_;
  Memory memory_;
};

}  // namespace palpate

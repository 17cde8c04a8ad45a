#pragma once

#include <array>
#include <cstdint>

#include "model/model.h"
#include "model/state.h"
#include "realtime/channels/command_queue.h"

namespace palpate {

/// Where the tools beside the first should be, and how far jaws should be open, tick by tick: as their scripts say
/// (ToolSetUp::path) from the last start on, until a hand or a recording takes one over.
/// Loop thread only. Real-time: no allocation, no lock, no throw. Test: realtime/loop/several_tools_test.cpp
class FurtherHands {
 public:
  explicit FurtherHands(const Model& model) : model_(model) {}

  /// A MoveHand or SetOpening. Nonsense is ignored.
  void take(const Request& request, Command& command);

  /// What the scripts say for this tick of the run.
  void next(std::int64_t tick, Command& command) const;

  /// All begin anew at this tick.
  void restart(std::int64_t tick);

  /// Plain data.
  struct Memory {
    std::int64_t begin = 0;                         // tick of the run
    std::array<bool, max_tools> moved{}, opened{};  // taken over: pose, opening
  };
  const Memory& memory() const { return memory_; }
  void recall(const Memory& memory) { memory_ = memory; }

 private:
  const Model& model_;
  Memory memory_;
};

}  // namespace palpate

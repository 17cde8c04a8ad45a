#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

#include "base/types.h"
#include "contact/tool_set.h"
#include "realtime/channels/triple_buffer.h"

namespace palpate {

/// Where a hand, program or device has the tool, with the number that the answer will carry.
struct HandPose {
  Pose pose;
  std::uint64_t sequence = 0;
};

/// The newest pose of one thread outside, to the loop: the latest wins, and nothing smooths it.
///   hand's thread:  back(), publish()
///   loop thread:    hasNews(), latest()
using HandSlot = TripleBuffer<HandPose>;

/// The same for the tools beside the first, and for how far jaws should be open: one thread for each tool.
struct ToolHands {
  std::array<HandSlot, max_tools - 1> further{
      {HandSlot(HandPose{}), HandSlot(HandPose{}), HandSlot(HandPose{})}};  // of tool 1, 2, 3
  std::array<std::atomic<double>, max_tools> opening;                       // m; not a number: no news

  ToolHands() {
    for (auto& wish : opening) wish.store(std::numeric_limits<double>::quiet_NaN(), std::memory_order_relaxed);
  }

  /// Loop: the newest wish since the last call; not a number: none.
  double takeOpening(int tool) {
    return opening[static_cast<std::size_t>(tool)].exchange(std::numeric_limits<double>::quiet_NaN(),
                                                            std::memory_order_relaxed);
  }

  /// Loop: what was sent before does not count.
  void forget() {
    for (HandSlot& hand : further) hand.latest();
    for (int k = 0; k < max_tools; ++k) takeOpening(k);
  }
};

}  // namespace palpate

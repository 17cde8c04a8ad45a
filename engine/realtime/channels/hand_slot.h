#pragma once

#include <cstdint>

#include "base/types.h"
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

}  // namespace palpate

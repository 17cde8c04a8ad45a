#pragma once

#include <cstdint>

#include "model/state.h"
#include "realtime/channels/command_queue.h"

namespace palpate {

/// Writes down each change of what moves the physics, with the tick of the run that it takes effect before:
/// what a Recording is made of.
/// Loop thread only (the other end of the ring is the viewer's). Real-time: no allocation, no lock, no throw.
class InputRecorder {
 public:
  /// From here on into `ring`, which must outlive this; null: writes down nothing.
  /// @param command  at rest, which is no change
  void startFrom(const Command& command, SpscRing<TimedRequest>* ring) {
    command_ = command;
    ring_ = ring;
    lost_ = 0;
  }

  void add(std::int64_t tick, const Request& request);

  /// What is new in the command of this tick.
  void addCommand(std::int64_t tick, const Command& command);

  /// The physics was put back (Reset or Undo), and the command is now this one.
  void addJump(std::int64_t tick, Request::Kind kind, const Command& command);

  /// Changes that found no room: the viewer took none for too long.
  std::int64_t lostCount() const { return lost_; }

 private:
  SpscRing<TimedRequest>* ring_ = nullptr;
  Command command_;  // as far as the recording tells
  std::int64_t lost_ = 0;
};

}  // namespace palpate

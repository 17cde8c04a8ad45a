#pragma once

#include <cstdint>

#include "base/types.h"

namespace palpate {

/// Where a run stands. Loop thread only.
struct RunState {
  std::int64_t tick = 0;        // ticks of the run that are done: the number of the present one
  std::int64_t tick_limit = 0;  // the run ends after so many; 0: never by itself
  bool starts_paused = false;   // the first Resume begins the run, and is no event
  bool paused = false;
  int single_steps = 0;             // ticks still to be made while paused
  bool frozen = false;              // the watchdog stopped the tissue
  bool stop = false;                // Quit was asked for
  Pose goal;                        // where the viewer's requests have led the hand
  Pose hand;                        // where the tool would be without tissue
  double yield = 0;                 // m, how far the tool stays behind it
  std::uint64_t pose_sequence = 0;  // of the newest pose from HandSlot
  std::int64_t undo_count = 0;
  std::int64_t reset_tick = 0;  // when it was last reset

  bool isOver() const { return stop || (tick_limit > 0 && tick >= tick_limit); }
};

}  // namespace palpate

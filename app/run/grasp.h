#pragma once

#include <vector>

#include "app/run/tool_hand.h"
#include "realtime/channels/snapshot.h"
#include "realtime/loop/tool_motion.h"

namespace palpate::app {

/// "Grasp and lift": closes the jaws until they hold, then lifts what they hold. They hold once they close no further
/// (the tool's grip_force), or are shut. By the run's time; belongs to the main thread.
class Grasp {
 public:
  static constexpr double lifting_speed = 0.015;  // m/s
  static constexpr double lift = 0.02;            // m
  static constexpr double still_seconds = 0.4;    // without closing: they hold

  /// What the hand does now. @param snapshot  of a scene whose first tool has jaws
  std::vector<Request> next(const Snapshot& snapshot, ToolHand& hand);
  /// It lifts, or has lifted: the hand goes on by itself.
  bool done() const { return done_; }

 private:
  double begin_s_ = -1, begin_opening_ = 0;   // s of the run, m
  double least_opening_ = 0, closed_at_ = 0;  // m, and when it was reached, s
  bool done_ = false;
};

}  // namespace palpate::app

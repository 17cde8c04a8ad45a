#pragma once

#include <vector>

#include "app/run/tool_hand.h"

namespace palpate::app {

/// What the demo shows while nobody is there: the probe presses here and there by itself, goes back to where it began,
/// rests, and begins again. Belongs to the main thread.
class AttractLoop {
 public:
  static constexpr double show_seconds = 30, rest_seconds = 30;  // in turn

  explicit AttractLoop(const Body& model);

  /// What the hand does now.
  /// @param seconds  since the loop began
  /// @param goal     where the simulation's own goal stands (Snapshot::goal_pose)
  std::vector<Request> next(double seconds, ToolHand& hand, const Pose& goal);

  /// Whether nothing moves for a while, and the run may wait.
  bool rests() const { return rests_; }

 private:
  std::vector<Vec3> places_;  // m, on the skin at rest
  double depth_;              // m
  int next_step_ = 0, round_ = 0;
  bool rests_ = false;
};

/// Places on the skin that the tool at its start looks at, far from each other, the nearest to it first.
std::vector<Vec3> facingPlaces(const Body& model, int count);

}  // namespace palpate::app

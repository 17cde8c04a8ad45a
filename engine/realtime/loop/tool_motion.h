#pragma once

#include "base/types.h"
#include "model/state.h"
#include "realtime/channels/command_queue.h"

namespace palpate {

/// m/s, of jaws that a button closes and opens.
inline constexpr double jaw_speed = 0.01;

/// Moves the tool from inside the loop, tick by tick: for runs too long to hold as a list of poses,
/// and for motions that depend on what the tissue does. Must depend on nothing but the states seen so
/// far, so that the run can be repeated. Called on the loop's thread: no allocation, no lock, no throw.
class ToolMotion {
 public:
  virtual ~ToolMotion() = default;

  /// The tool's target for the coming tick.
  /// @param last  outcome of the tick before; empty at the first tick
  virtual Pose next(const State& state, const StepReport& last) = 0;

  /// How far the first tool's jaws should be open in that tick, m; < 0: it does not say. Called after next().
  virtual double opening() const { return -1; }

  /// Friction or a material that is to change before the coming tick; called before next() until there is none more.
  virtual const Request* nextSetting() { return nullptr; }

  /// Of the outside's pose that next() went by (HandPose::sequence); 0: there is none.
  virtual std::uint64_t poseSequence() const { return 0; }

  /// The physics was reset: begin again.
  virtual void restart() = 0;
};

}  // namespace palpate

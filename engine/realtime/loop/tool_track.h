#pragma once

#include <cstdint>
#include <vector>

#include "realtime/channels/command_queue.h"
#include "realtime/loop/tool_goal.h"
#include "realtime/loop/tool_motion.h"

namespace palpate {

/// What drives the tool, tick by tick: a ToolMotion or a track given in advance (tool script, replay) while it
/// lasts; then the viewer, whose newest pose the tool follows smoothly.
/// Loop thread only. Real-time: no allocation, no lock, no throw; but not the constructor.
class ToolTrack {
 public:
  /// @param track    ascending ticks, counted from the track's begin
  /// @param ticks    how long track or motion lasts; 0: to the track's last entry, or a motion without end
  /// @param motion   drives instead of the track; must outlive this. Null: none
  /// @param start    pose of the tool at rest
  ToolTrack(std::vector<TimedRequest> track, std::int64_t ticks, ToolMotion* motion, const Pose& start, double rate_hz);

  /// Whether track or motion has the tool in this tick of the run, so that the viewer has not.
  bool drives(std::int64_t tick) const;

  /// The track's next request that takes effect before this tick of the run; null: none is due.
  const Request* takeDue(std::int64_t tick);

  /// The place of the track's next GoToPlace; no_place: there is none.
  const PlaceIndex& nextPlace();

  /// The motion's next change of a setting before this tick; null: none more.
  const Request* takeSetting(std::int64_t tick, bool frozen);

  /// Where the viewer's requests lead the tool once nothing else drives it.
  ToolGoal& goal() { return goal_; }
  const ToolGoal& goal() const { return goal_; }

  /// The tool's target in this tick of the run.
  /// @param present  the target of the tick before, or what the track has just set
  /// @param last     the tick before's outcome
  /// @param frozen   the tissue does not move: a motion, which goes by the tissue, waits
  Pose next(std::int64_t tick, const Pose& present, const State& state, const StepReport& last, bool frozen);

  /// How far the motion wants the first tool's jaws open in this tick, m; < 0: it does not say. After next().
  double opening(std::int64_t tick, bool frozen) const;

  /// The physics was reset: the target is the start again, and a motion begins again.
  void reset();

  /// The track, or a motion that has an end, begins again at this tick of the run. False where there is neither.
  bool startOver(std::int64_t tick);

 private:
  const std::vector<TimedRequest> track_;
  const std::int64_t end_;  // ticks that track or motion lasts
  ToolMotion* const motion_;
  const Pose start_;
  const double follow_gain_;         // share of the way to the goal that the tool goes in one tick
  std::int64_t begin_ = 0;           // tick of the run at which track or motion began
  std::size_t next_ = 0;             // of track_, to be taken
  std::vector<std::size_t> places_;  // which of track_ are GoToPlace
  std::size_t next_place_ = 0;       // of these
  ToolGoal goal_;                    // the viewer's
};

}  // namespace palpate

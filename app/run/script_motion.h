#pragma once

#include <utility>

#include "io/script_trajectory.h"
#include "realtime/loop/tool_motion.h"

namespace palpate::app {

/// Moves the tool as a script says, whatever the tissue does.
class ScriptMotion final : public ToolMotion {
 public:
  explicit ScriptMotion(ScriptTrajectory trajectory) : trajectory_(std::move(trajectory)) {}

  std::int64_t ticks() const { return trajectory_.ticks(); }
  Pose next(const State&, const StepReport&) override { return trajectory_.next(); }
  double opening() const override { return trajectory_.opening(); }
  void restart() override { trajectory_.restart(); }

 private:
  ScriptTrajectory trajectory_;
};

}  // namespace palpate::app

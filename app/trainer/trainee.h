#pragma once

#include <vector>

#include "app/trainer/lumps.h"
#include "app/trainer/task_score.h"
#include "realtime/loop/tool_motion.h"

namespace palpate::app {

/// A trainee by rule: presses the skin at the places of a grid, feels the slope of force over depth, and marks the
/// places that are clearly stiffer than the others around: a yardstick for layouts and scores. The motion belongs to
/// the loop's thread, places() and marks() to others once the run has ended.
class Trainee final : public ToolMotion {
 public:
  /// @param depth  m that it presses; @param step  m between places
  Trainee(const Model& model, double depth, double step);

  Pose next(const State& state, const StepReport& last) override;
  void restart() override;

  std::int64_t ticks() const { return ticks_per_place_ * static_cast<std::int64_t>(places_.size()) + 1; }
  const std::vector<SkinSurface::Place>& places() const { return places_; }
  const std::vector<double>& slopes() const { return slopes_; }  // (place_count) N/m

  /// Places whose slope is the highest within three steps (both sides of a lump are one), and at least 1.25 times
  /// the median of those around. Of the assets' first level places without a lump come to 1.19 times, those by one to
  /// 1.31.
  std::vector<Vec3> marks() const;

 private:
  const double depth_, step_, rate_hz_;
  std::vector<SkinSurface::Place> places_;
  std::vector<double> slopes_;
  std::int64_t ticks_per_place_, tick_ = 0;
  double first_ = 0;  // N, where the slope begins
  Pose start_;
};

}  // namespace palpate::app

#pragma once

#include <map>
#include <memory>
#include <vector>

#include "mtled/run/scripted_run.h"
#include "setup/passage.h"

namespace palpate::tools {

/// Places that were made, by their index. All stay in memory: for batch.
class PlaceShelf {
 public:
  explicit PlaceShelf(const Places& places) : places_(places) {}
  const Place& at(const PlaceIndex& index);
  double seconds() const { return seconds_; }  // processor time of all threads spent on making them
  int count() const { return static_cast<int>(shelf_.size()); }

 private:
  const Places& places_;
  std::map<PlaceIndex, std::unique_ptr<Place>> shelf_;
  double seconds_ = 0;
};

/// A change from one place to the next, beside the same run without it.
struct Swap {
  int tick = 0;
  int new_nodes = 0, rows = 0;  // of the passage
  double apply_us = 0;          // processor time of applyPassage
  bool loaded = false;          // there was a force to compare
  double first = 0;             // |force - that of the run without it| over the latter, in the first tick
  double worst = 0;             // the same, largest of 120 ms
};

struct FollowingRun {
  ScriptedRun run;  // tick_us: processor time of the ticks alone
  std::vector<Swap> swaps;
  int fewest_nodes = 0, most_nodes = 0;
  int substeps = 0;
};

/// Follows a trajectory with a place for wherever the tools are; the swaps are told of the first one's force.
/// @param probes  as runTrajectory's
FollowingRun followTrajectory(const Places& places, PlaceShelf& shelf, const ToolTrajectory& way,
                              const std::vector<Vec3>& probes = {}, int threads = 1);

/// The same of a model that stays, measured alike.
ScriptedRun trajectoryOn(const Model& model, const ToolTrajectory& way);

}  // namespace palpate::tools

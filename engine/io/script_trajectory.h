#pragma once

#include <cstdint>
#include <vector>

#include "io/tool_script.h"

namespace palpate {

/// A tool script's poses at the end of each tick, one after another, its corners rounded: each position is the mean
/// of those within 20 ms. No hand changes its speed within a tick, and tissue answers such a jerk with a step of force.
/// Only those 40 ms are held, however long the script is.
class ScriptTrajectory {
 public:
  /// @param first_contact_travel  m from the start pose to first touch (ToolSetUp::first_contact_travel)
  /// @param opening  m, of jaws at the start; < 0: no jaws
  ScriptTrajectory(ToolScript script, const Pose& start, double first_contact_travel, double rate_hz,
                   double opening = -1);

  /// Ticks until the tool stands still.
  std::int64_t ticks() const { return last_ + 1 + reach_; }

  /// The pose at the end of the next tick; after ticks() of them, where the tool stands.
  /// Real-time: no allocation, no lock, no throw; cost ~ rate.
  Pose next();

  /// How far jaws are open in the tick that next() was for last, m, rounded likewise; < 0: no jaws.
  double opening() const { return opening_; }

  /// Begins again.
  void restart();

 private:
  /// Computes the script's own position at the end of tick k, unless it is held.
  void hold(std::int64_t k);
  Vec3& held(std::int64_t k) { return position_[static_cast<std::size_t>(k) % position_.size()]; }

  ToolScript script_;
  Pose start_;
  double first_contact_travel_, rate_hz_;
  std::int64_t reach_;     // ticks to each side over which the mean goes
  std::int64_t last_;      // tick in which the script ends
  std::int64_t tick_ = 0;  // that next() is for
  std::int64_t held_ = 0;  // the script's own positions are known up to before this tick
  double start_opening_, opening_;
  std::vector<double> held_opening_;  // m; as position_, empty without jaws
  std::vector<Vec3> position_;        // m; of the last 2 reach_ + 1 ticks, tick k at k modulo the length
};

}  // namespace palpate

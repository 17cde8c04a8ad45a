#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "app/run/result_folder.h"
#include "app/run/skin_crossings.h"
#include "app/run/soak_motion.h"
#include "app/run/soak_report.h"
#include "realtime/loop/simulation_loop.h"
#include "setup/place.h"

namespace palpate::app {

/// A long run under a tool that never stops, watched for what must not change: memory, the state at
/// rest, finite numbers. Belongs to the main thread; motion() to the loop's.
class Soak {
 public:
  static constexpr double interval_seconds = 60;      // wall time between lines and reports
  static constexpr double crossings_seconds = 0.1;    // of physics, at least, between looks at the skin
  static constexpr double warm_physics_seconds = 20;  // by then every buffer of the program has its size

  /// @param minutes  of physics time
  /// @param rough    a RoughMotion instead of a SoakMotion
  /// @param places  where the cloud follows the tool, else null
  Soak(const Model& model, const Places* places, double minutes, bool rough, unsigned seed);

  ToolMotion& motion() { return *hand_; }

  /// Takes what the loop has to tell; prints and writes the report once a minute. At least once a second.
  void update(SimulationLoop& loop, const ResultFolder& results);

  /// After the loop's end: the last report.
  /// @return the promises that were broken, as one sentence; empty: all kept
  std::string finish(SimulationLoop& loop, const ResultFolder& results, bool interrupted);

 private:
  using SteadyClock = std::chrono::steady_clock;

  void takeCycles();
  void lookAtSkin(const Snapshot& snapshot);
  void warmUp(SimulationLoop& loop, const ResultFolder& results);
  void measure(SimulationLoop& loop);
  void countThreads(const SimulationLoop& loop);
  void write(const ResultFolder& results) const;

  std::unique_ptr<SoakHand> hand_;
  SkinCrossings skin_;
  SoakReport report_;
  double rate_hz_;
  std::int64_t looked_at_ = 0;  // tick of the last look at the skin,
  int seen_ = 0;                // and how often it crossed itself
  std::vector<SoakThread> warm_threads_;
  SteadyClock::time_point begin_ = SteadyClock::now(), last_report_ = begin_, last_counters_ = begin_;
};

}  // namespace palpate::app

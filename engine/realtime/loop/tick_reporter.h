#pragma once

#include <memory>

#include "base/spin_team.h"
#include "contact/true_depth.h"
#include "realtime/loop/contact_trend.h"
#include "realtime/loop/force_filter.h"
#include "realtime/loop/loop_channels.h"
#include "realtime/loop/physics.h"
#include "realtime/loop/run_memory.h"
#include "realtime/loop/run_state.h"
#include "realtime/loop/run_summary.h"
#include "realtime/loop/watchdog.h"
#include "realtime/timing/overload_watch.h"

namespace palpate {

/// Tells of each tick what others want to know: judges the physics' report, filters the force, fills the
/// channels (force, snapshot, log, late ticks) and sums up the run.
/// Loop thread only; summary() also by others once the run has ended.
/// Real-time: no allocation, no lock, no throw; but not the constructor and finish.
class TickReporter {
 public:
  /// All must outlive this. @param team  whose workers may keep the loop waiting, or null
  TickReporter(const Model& model, const Physics& physics, const SpinTeam* team, LoopChannels& channels);

  /// A period begins.
  void beginTick(const LoopTime& time, const RunState& run);

  /// The body has other nodes from here on. @param swapped  it went from place to place; else to an earlier state
  void goOnAt(const std::shared_ptr<ReadyPlace>& place, bool swapped);
  /// The coming tick's: whether its place is late.
  void notePlace(bool late) { force_.place_late = late; }

  /// The physics has done a tick.
  Verdict judge(const StepReport& report, const RunState& run);

  /// After the verdict Restore: how often that was so within the last second before.
  int recentLosses() const { return watchdog_.recentLosses(); }

  /// The physics went back to an earlier state. @param cause  a LogEvent::isRestore(), which is logged already
  void restored(LogEvent::Kind cause);

  /// In this tick a tool, stuck in the tissue, lets it go.
  void letGo(const RunState& run, int tool);

  /// The tick is done, frozen or not, and counted in `run`: its force goes out.
  void sendForce(const LoopTime& time, const RunState& run);

  /// The period is done, paused or not: its snapshot goes out.
  void publish(const LoopTime& time, const RunState& run);

  /// The tick before, by `run`, was not done at the next grid time.
  void addLate(const LateTick& measured, const LoopTime& time, const RunState& run);

  /// The physics was reset, or the last seconds undone. The force filter is left as it is: the force in a hand goes
  /// back smoothly, too.
  void reset();

  /// Adds to, or takes from, what another loop of this model is to go on from.
  void tell(RunMemory& memory) const;
  void recall(const RunMemory& memory);

  void logEvent(LogEvent::Kind kind, const RunState& run, int index = -1, double value = 0,
                const Vec3& position = Vec3::Zero());

  /// The run has ended.
  void finish(const LoopTotals& totals, const RunState& run, std::int64_t lost_records);

  /// The last tick's, as it was judged.
  const StepReport& lastReport() const { return report_; }
  Doubt lastDoubt() const { return force_.doubt; }
  RunSummary& summary() { return summary_; }
  const RunSummary& summary() const { return summary_; }

 private:
  void watchYield(const RunState& run);
  void watchSwap(const Vec3& expected, const Vec3& before);
  void readTools(const RunState& run);
  Pose firstBody() const;
  void showState();
  double secondsAt(std::int64_t tick) const { return static_cast<double>(tick) / model_->scene.dynamics.rate_hz; }

  const Model* model_;                  // the present one
  std::shared_ptr<const Place> place_;  // that it is of; null where the cloud stays
  bool swapped_ = false;                // before the present tick
  Vec3 force_before_ = Vec3::Zero();    // N, of the tick before the last
  const Physics& physics_;
  const SpinTeam* team_;
  LoopChannels& channels_;
  const Vec3 tool_axis_;  // unit, the way the tool advances
  const TrueDepth depth_;
  ForceFilter filter_;
  ContactTrend trend_;
  Watchdog watchdog_;
  OverloadWatch overload_;
  std::int64_t long_waits_ = 0;  // of the team, before the present tick
  StepReport report_;
  ForceSample force_;
  ToolReadings readings_;
  std::int64_t last_yield_tick_ = -1;
  AlignedVector<Float4> shown_u_;  // the last displacement worth showing
  RunSummary summary_;
};

}  // namespace palpate

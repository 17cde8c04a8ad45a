#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "realtime/channels/command_queue.h"
#include "realtime/channels/force_output.h"
#include "realtime/channels/log_event.h"
#include "realtime/channels/snapshot_buffer.h"
#include "realtime/loop/force_filter.h"
#include "realtime/loop/physics.h"
#include "realtime/loop/thread_setup.h"
#include "realtime/loop/tool_motion.h"
#include "realtime/loop/watchdog.h"
#include "realtime/timing/fixed_step_loop.h"
#include "realtime/timing/overload_watch.h"

namespace palpate {

struct SimulationLoopOptions {
  bool as_fast_as_possible = false;
  std::int64_t tick_limit = 0;  // the loop ends after so many ticks; 0: at Quit only
  bool start_paused = false;    // the first Resume then begins the run, and is no event
  bool record = false;          // hand all input changes to recorded()
  /// Input given in advance (tool script or replay), ascending ticks. While it lasts, it
  /// alone moves the tool; the viewer may still pause, step, reset (which starts it
  /// over) and quit.
  std::vector<TimedRequest> track;
  std::int64_t track_ticks = 0;  // how long it lasts; 0: to its last entry
  /// Moves the tool instead of a track, to the end of the run; must outlive the loop. Null: none.
  ToolMotion* motion = nullptr;
  std::size_t force_capacity = 1 << 16;   // samples kept until the viewer takes them
  std::size_t record_capacity = 1 << 16;  // changes kept until the viewer takes them
};

/// The facts of a run that has ended.
struct RunSummary {
  std::int64_t ticks = 0;  // of the run, frozen ones included
  LoopTotals totals;
  std::uint64_t state_hash = 0;
  std::uint32_t flags = 0;              // StepFlag, all ticks
  float min_J = 1;                      // lowest of all ticks
  Doubt doubt = Doubt::None;            // the gravest of all ticks
  std::int64_t first_doubt_tick = -1;   // of the run; -1: none
  double peak_force = 0;                // N, raw
  Vec3 base_reaction = Vec3::Zero();    // N, last tick
  std::int64_t lost_force_samples = 0;  // ring full: nobody took them
  std::int64_t lost_records = 0;
  bool frozen = false;  // at the end
  RtSetup rt_setup;
};

/// The simulation in time: each tick takes the newest input, advances the physics by
/// 1 / rate, filters the force, lets the watchdog judge, and publishes a snapshot and
/// a force sample. "Tick k of the run" counts ticks since the start (pauses left out,
/// resets and frozen ticks included); its time is exactly k / rate. State::tick counts
/// physics ticks since the start or the last reset.
///
/// Threads: one viewer thread uses the functions marked (viewer); the loop's own
/// thread does the rest. Nothing that the viewer does or omits delays a tick.
class SimulationLoop final : private LoopBody {
 public:
  /// Both must outlive the loop. Takes all memory here.
  /// @param team  physics threads to prepare for real time, or null
  SimulationLoop(const Model& model, Physics& physics, SpinTeam* team, SimulationLoopOptions options);
  ~SimulationLoop() override;  // quits and joins

  /// (viewer) Runs on a thread of its own; join() waits for its end.
  void start();
  void join();
  /// (viewer) Runs on the calling thread until the end. In real-time mode use start():
  /// what is asked of the system for the thread (SCHED_FIFO, ...) stays with it. With a
  /// `clock` given, nothing is asked and denormals are not flushed; that is for tests.
  void run();
  void run(Clock& clock);

  /// (viewer) Asks the loop to end; safe also when the command queue is full.
  void quit() { quit_.store(true, std::memory_order_relaxed); }
  bool finished() const { return finished_.load(std::memory_order_acquire); }

  CommandQueue& commands() { return commands_; }                        // (viewer) push
  SnapshotBuffer& snapshots() { return snapshots_; }                    // (viewer) latest
  SpscRing<ForceSample>& forces() { return forces_; }                   // (viewer) pop
  LogRing& log() { return log_; }                                       // (viewer) pop
  SpscRing<TimedRequest>& recorded() { return recorded_; }              // (viewer) pop
  const DeadlineStatistics& statistics() const { return statistics_; }  // any thread
  /// (any thread, any number of them) The newest force with its age: what a haptic device or a
  /// readout goes by. Under overload, in a pause and after the end it grows old and is not fresh.
  ForceReading force() const;

  /// (viewer) After the end.
  const RunSummary& summary() const { return summary_; }

 private:
  TickOutcome onTick(const LoopTime& time) override;
  void onLate(const LateTick& late, const LoopTime& time) override;
  void takeRequests();
  void takeTrack();
  void apply(const Request& request, bool from_track);
  void resetPhysics();
  void startTrackOver();
  void setFriction(const Request& request);
  void setMaterial(const Request& request);
  bool trackDrives() const;
  void advance(const LoopTime& time);
  void publish(const LoopTime& time);
  void record(const Request& request);
  void recordCommand();
  void logEvent(LogEvent::Kind kind, int index = -1, double value = 0);

  const Model& model_;
  Physics& physics_;
  SpinTeam* team_;
  const SimulationLoopOptions options_;
  const Vec3 tool_axis_;  // unit, the way the tool advances
  const double follow_gain_;
  const double loaded_friction_;  // what live changes started from
  const std::vector<Material> loaded_materials_;
  const std::int64_t track_end_;

  CommandQueue commands_;
  SnapshotBuffer snapshots_;
  SpscRing<ForceSample> forces_;
  ForceOutput newest_force_;
  LogRing log_;
  SpscRing<TimedRequest> recorded_;
  DeadlineStatistics statistics_;
  std::atomic<bool> quit_{false};
  std::atomic<bool> finished_{false};
  std::thread thread_;

  // The loop thread's own.
  ForceFilter filter_;
  Watchdog watchdog_;
  OverloadWatch overload_;
  std::int64_t long_waits_ = 0;  // of the team, before the present tick
  Command command_;              // of the present tick
  Command recorded_command_;     // as far as the recording tells
  Pose viewer_target_;           // where the viewer wants the tool
  StepReport report_;
  ForceSample force_;
  AlignedVector<Float4> shown_u_;  // the last displacement worth showing
  double friction_;
  std::int64_t run_tick_ = 0;
  std::int64_t track_start_ = 0;  // run tick at which the track began
  std::size_t track_next_ = 0;
  bool paused_ = false;
  bool frozen_ = false;
  bool step_once_ = false;
  bool stop_ = false;
  RunSummary summary_;
};

}  // namespace palpate

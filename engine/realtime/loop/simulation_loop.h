#pragma once

#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "realtime/loop/cloud_follower.h"
#include "realtime/loop/fold_watch.h"
#include "realtime/loop/further_hands.h"
#include "realtime/loop/input_recorder.h"
#include "realtime/loop/live_settings.h"
#include "realtime/loop/loop_channels.h"
#include "realtime/loop/physics.h"
#include "realtime/loop/run_memory.h"
#include "realtime/loop/run_state.h"
#include "realtime/loop/run_summary.h"
#include "realtime/loop/state_history.h"
#include "realtime/loop/tick_listener.h"
#include "realtime/loop/tick_reporter.h"
#include "realtime/loop/tool_proxy.h"
#include "realtime/loop/tool_track.h"
#include "realtime/timing/fixed_step_loop.h"

namespace palpate {

struct SimulationLoopOptions {
  bool as_fast_as_possible = false;
  std::int64_t tick_limit = 0;  // the loop ends after so many ticks; 0: at Quit only
  bool start_paused = false;    // the first Resume then begins the run, and is no event
  std::vector<std::int64_t>
      pause_at{};       // ascending: paused after so many ticks, so that others can look at just that one
  bool record = false;  // hand all input changes to recorded()
  /// Input given in advance (tool script or replay), ascending ticks. While it lasts, it
  /// alone moves the tool; the viewer may still pause, step, reset (which starts it
  /// over) and quit.
  std::vector<TimedRequest> track;
  std::int64_t track_ticks = 0;  // how long it lasts; 0: to its last entry, or, of a motion, without end
  /// Moves the tool instead of a track, for track_ticks; must outlive the loop. Null: none.
  ToolMotion* motion = nullptr;
  /// Moves the tool wherever no track does, beside which the viewer may change what it likes but the tool: a haptic
  /// device's (realtime/device/coupled_tool.h). Must outlive the loop. Null: none.
  ToolMotion* device = nullptr;
  /// Has the physics at the place for where the tool is; must outlive the loop. Null: the cloud stays.
  CloudFollower* follower = nullptr;
  bool track_has_places = false;  // a replay's: while the track lasts, it alone says when the cloud goes where
  bool undo = true;               // past states are kept for the viewer to go back to
  bool keeps_settings = false;    // friction and materials stay as they were set when track or motion starts over
  std::size_t force_capacity = 1 << 16;   // samples kept until the viewer takes them
  std::size_t record_capacity = 1 << 16;  // changes kept until the viewer takes them
};

/// The simulation in time: each tick takes the newest input, advances the physics by
/// 1 / rate, filters the force, lets the watchdog judge, and publishes a snapshot and
/// a force sample. Where the solution is lost, the tissue goes back to an earlier state,
/// and the tool comes back gently. "Tick k of the run" counts ticks since the start
/// (pauses left out, resets and frozen ticks included); its time is exactly k / rate.
/// State::tick counts physics ticks since the start or the last reset, less those gone
/// back.
///
/// Threads: one viewer thread uses the functions marked (viewer); the loop's own
/// thread does the rest. Nothing that the viewer does or omits delays a tick. The loop's
/// thread takes no lock and sleeps only between ticks; the workers of its team sleep
/// between ticks, too, on a futex, and are woken by one system call at a tick's begin
/// (SpinTeam).
class SimulationLoop final : private LoopBody {
 public:
  /// Both must outlive the loop. Takes all memory here.
  /// @param team  physics threads to prepare for real time, or null
  SimulationLoop(const Model& model, Physics& physics, SpinTeam* team, SimulationLoopOptions options);
  ~SimulationLoop() override;  // quits and joins

  /// (viewer) Runs on a thread of its own; join() waits for its end. After that it may be started again, and goes on.
  void start();
  void join();
  /// (viewer) While no thread runs: whether start() asks the system for what a fixed rate needs (setUpLoopThread).
  void setRealTime(bool wanted) { real_time_ = wanted && !as_fast_as_possible_; }
  /// (viewer) Runs on the calling thread until the end. In real-time mode use start():
  /// what is asked of the system for the thread (SCHED_FIFO, ...) stays with it. With a
  /// `clock` given, nothing is asked and denormals are not flushed; that is for tests.
  void run();
  void run(Clock& clock);

  /// (viewer) While no thread runs: another device moves the tool from now on, as SimulationLoopOptions::device, or
  /// with null none.
  void setDevice(ToolMotion* device) { device_ = device; }
  /// (viewer) While no thread runs: who is told of each tick from now on; null: nobody.
  void setListener(TickListener* listener) { listener_ = listener; }

  /// (viewer) While no thread runs, does the next ticks on the calling one, bit for bit as run() would: the tool is at
  /// each tick's end where `hand()` has it. 0: takes what was asked of commands() and hand(), and does no tick.
  /// Denormals are flushed meanwhile. Publishes at the end.
  void advanceHere(std::int64_t ticks);

  /// (viewer) While no thread runs: the changes of input go there from now on, in place of recorded(); null: nowhere. A
  /// recording begins before the first tick.
  void record(SpscRing<TimedRequest>* into);
  /// (viewer) While no thread runs: changes that have found no room since then.
  std::int64_t lostChanges() const { return recorder_.lostCount(); }

  /// (viewer) While no thread runs: what another loop of this model goes on from, together with the physics' state.
  /// What was kept to go back to (StateHistory), and the watchdog's memory of losses, begin anew there.
  RunMemory memory() const;
  void recall(const RunMemory& memory);

  /// (any thread) Asks the loop to end; safe also when the command queue is full. A long tick under way is broken
  /// off, and the run ends as it was before it.
  void quit() { channels_.quit.store(true, std::memory_order_relaxed); }
  bool finished() const { return channels_.finished.load(std::memory_order_acquire); }

  /// (one thread) The latest pose wins. The tool goes there at once, as fast as the scene lets it, while no track
  /// drives.
  HandSlot& hand() { return channels_.hand; }
  /// (a thread for each tool) The same for tools beside the first, and for how far jaws should be open.
  ToolHands& toolHands() { return channels_.tool_hands; }
  CommandQueue& commands() { return channels_.commands; }            // (viewer) push
  SnapshotBuffer& snapshots() { return channels_.snapshots; }        // (viewer) latest
  SpscRing<ForceSample>& forces() { return channels_.forces; }       // (viewer) pop
  SpscRing<ToolReadings>& tools() { return channels_.tools; }        // (viewer) pop, one after each of forces(), if any
  LogRing& log() { return channels_.log; }                           // (viewer) pop
  SpscRing<TimedRequest>& recorded() { return channels_.recorded; }  // (viewer) pop
  const DeadlineStatistics& statistics() const { return channels_.statistics; }  // any thread
  /// (any thread, any number of them) The newest force with its age: what a haptic device or a
  /// readout goes by. Under overload, in a pause and after the end it grows old and is not fresh.
  ForceReading force() const;
  /// (any thread, any number of them) The newest readings of all tools, where the scene has several or jaws.
  ToolReadings toolReadings() const { return channels_.newest_tools.latest(); }

  /// (viewer) After the end; rt_setup also once a tick has been published.
  const RunSummary& summary() const { return reporter_.summary(); }

 private:
  TickOutcome onTick(const LoopTime& time) override;
  std::int64_t waited() const override { return follower_ ? follower_->waited() : 0; }
  void onLate(const LateTick& late, const LoopTime& time) override;
  void takeRequests();
  void takeHand();
  void takeFurtherHands();
  void apply(const Request& request, bool from_track);
  void moveTool(const Request& request, bool from_track);
  void steer(const Request& request);
  void pull(int skin_vertex, const Vec3& target);
  void change(const Request& setting);
  void say(const Request& said, bool from_track);
  void reset(Request::Kind kind, bool from_track);
  void undo();
  void beGentle();
  void followHands(Command& command);
  void goBackTo(const State& past);
  bool followTool();
  void goToPlace(const PlaceIndex& index);
  void goOnAtPlace(bool swapped);
  void openJaws(double opening);
  bool advance();  // false: quit() broke the tick off, which then never was
  bool step();     // likewise
  bool hasFolded(const StepReport& report);

  const Model& model_;
  Physics& physics_;
  SpinTeam* team_;
  const bool as_fast_as_possible_;
  const bool keeps_settings_;
  ToolMotion* device_;
  CloudFollower* const follower_;
  const bool track_has_places_;
  bool waits_;  // for places that are not ready
  TickListener* listener_ = nullptr;
  const std::vector<std::int64_t> pause_at_;
  std::size_t next_pause_ = 0;  // of pause_at_
  bool real_time_;
  LoopChannels channels_;
  std::thread thread_;

  // The loop thread's own.
  RunState run_;
  Command command_;  // of the present tick; its tool is where the hand is
  ToolTrack track_;
  FurtherHands further_;
  std::vector<ToolProxy> proxies_;  // (tool_count)
  StateHistory history_;
  FoldWatch folds_;
  LiveSettings settings_;
  InputRecorder recorder_;
  TickReporter reporter_;
};

}  // namespace palpate

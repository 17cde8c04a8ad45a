#pragma once

#include <atomic>
#include <cstddef>

#include "model/model.h"
#include "model/state.h"
#include "realtime/channels/command_queue.h"
#include "realtime/channels/force_output.h"
#include "realtime/channels/hand_slot.h"
#include "realtime/channels/log_event.h"
#include "realtime/channels/snapshot_buffer.h"
#include "realtime/channels/tool_readings.h"
#include "realtime/timing/deadline_statistics.h"

namespace palpate {

/// All that passes between the loop's thread and the others. Each member says which thread may do what;
/// "viewer" is the one thread that draws and asks. The constructor takes all memory; nothing here waits.
struct LoopChannels {
  /// @param force_capacity   force samples kept until the viewer takes them
  /// @param record_capacity  changes of input, likewise
  LoopChannels(const Model& model, const State& state, std::size_t force_capacity, std::size_t record_capacity);

  CommandQueue commands;              // viewer: push; loop: pop
  HandSlot hand;                      // hand's thread: back, publish; loop: latest
  ToolHands tool_hands;               // each hand's thread: as `hand`; loop: latest
  SnapshotBuffer snapshots;           // loop: back, publish; viewer: latest
  SpscRing<ForceSample> forces;       // loop: push; viewer: pop
  ForceOutput newest_force;           // loop: publish; any thread: latest
  SpscRing<ToolReadings> tools;       // one for each force where the scene has several tools or jaws; as `forces`
  ToolsOutput newest_tools;           // likewise; loop: publish; any thread: latest
  LogRing log;                        // loop: push; viewer: pop
  SpscRing<TimedRequest> recorded;    // loop: push; viewer: pop
  DeadlineStatistics statistics;      // loop: writes; any thread: reads
  std::atomic<bool> quit{false};      // any thread: sets; loop: reads
  std::atomic<bool> finished{false};  // loop: sets at its end; any thread: reads
};

}  // namespace palpate

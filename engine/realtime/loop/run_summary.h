#pragma once

#include <cstdint>
#include <optional>

#include "model/state.h"
#include "realtime/channels/log_event.h"
#include "realtime/loop/thread_setup.h"
#include "realtime/timing/fixed_step_loop.h"
#include "step/trust.h"

namespace palpate {

/// How often the tissue went back to an earlier state, by what it was lost to.
struct Restores {
  std::int64_t lost = 0;    // not finite, or blown up (Watchdog)
  std::int64_t folded = 0;  // FoldWatch

  void count(LogEvent::Kind kind) { ++(kind == LogEvent::Kind::RestoredFolded ? folded : lost); }
};

/// How a cloud followed the tool in a run.
struct FollowTotals {
  std::int64_t swaps = 0;       // from place to place
  std::int64_t late_ticks = 0;  // on a place that was not the one for where the tools are: it was not ready
  double longest_swap_us = 0;   // on the loop's thread
  double largest_jump_N = 0;    // of the first tool's raw force in a swap's first tick: what the two before don't lead
                                // one to expect
  double largest_jump_share = 0;  // the same over the force before, where that is above 2 % of the run's largest
};

/// The facts of a run that has ended.
struct RunSummary {
  std::int64_t ticks = 0;  // of the run, frozen ones included
  LoopTotals totals;
  std::uint64_t state_hash = 0;
  std::uint32_t flags = 0;                                        // StepFlag, all ticks
  float min_J = 1;                                                // lowest of all ticks
  RunTrust trust;                                                 // of all ticks
  double peak_force = 0;                                          // N, raw
  double peak_depth = 0;                                          // m, true depth
  std::array<double, max_tools> peak_tool_force{}, peak_pinch{};  // N, where there are several tools or jaws
  std::int64_t restored_count = 0;  // times that the solution was lost, and the tissue went back to an earlier state
  Restores restores;                // the same by cause, of this run alone
  std::int64_t let_go_count = 0;    // times that a tool was stuck, and let the tissue go (ToolProxy)
  double largest_yield = 0;         // m, that the tool stayed behind the hand (ToolProxy)
  std::int64_t yielding_ticks = 0;
  Vec3 base_reaction = Vec3::Zero();    // N, last tick
  OrganForces organ_force{};            // N, of the other organs on each, last tick
  double skin_penetration = 0;          // m, of organs into one another, largest of all ticks
  RigidLoads rigid;                     // on the tissue: forces of the last tick, the deepest of all
  std::int64_t lost_force_samples = 0;  // ring full: nobody took them
  std::int64_t lost_records = 0;
  bool frozen = false;                 // at the end
  std::optional<FollowTotals> follow;  // where the cloud follows the tool
  RtSetup rt_setup;
};

}  // namespace palpate

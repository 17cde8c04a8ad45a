#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "model/model.h"
#include "realtime/loop/run_summary.h"
#include "realtime/timing/deadline_statistics.h"

namespace palpate {

/// All that report.json says about a run.
struct RunReport {
  std::string scene;
  int nodes = 0, integration_points = 0;
  double mean_support = 0;  // nodes per integration point
  double cells_per_point = 1;
  GradientPrecision gradient_precision = GradientPrecision::Float32;  // of the real-time kernel
  double dt_s = 0, dt_critical_s = 0, rate_hz = 0;
  double added_mass = 0;  // share of the body's own (scene.dynamics.mass_scaling)
  int substeps_per_tick = 0;
  std::int64_t ticks = 0, overruns = 0, longest_overrun_streak = 0;
  std::int64_t caught_up = 0;                              // ticks that were late and made good
  std::array<std::int64_t, kLateCauseCount> late_ticks{};  // late by themselves, by LateCause
  double physics_seconds = 0, wall_seconds = 0, realtime_factor = 0;
  Percentiles step_us, wakeup_late_us;
  RtSetup rt_setup;
  int threads = 0;
  double min_J = 1;
  double volume_error = 0;   // of the background cells against the organ's own surface, relative
  double volume_change = 0;  // of the integration points at the end, relative
  double peak_force_N = 0;
  struct Tool {
    double peak_force_N = 0, peak_pinch_N = 0;
    bool jaws = false;
  };
  std::vector<Tool> tools;  // where the scene has several or jaws; else empty, and report.json has no "tools"
  double peak_depth_m = 0;  // of the skin under the tip, from where it lay at rest
  Vec3 base_reaction_N = Vec3::Zero();
  struct Region {
    std::string name;
    Reaction on_tissue;  // last step
  };
  std::vector<Region> regions;  // that are held or moved
  struct Organ {
    std::string name;
    Vec3 contact_force_N = Vec3::Zero();
  };
  std::vector<Organ> organs;  // where the scene has several; else empty, and report.json has no "organs"
  double organ_penetration_m = 0;
  struct Rigid {
    std::string name;
    Vec3 force_N = Vec3::Zero();           // on the tissue, last tick
    double penetration_m = 0;              // the deepest
    std::optional<double> expected_error;  // of the force, as a share, where it is round and presses
  };
  std::vector<Rigid> rigid;  // where the scene has rigid bodies; else report.json has no "rigid"
  std::uint64_t state_hash = 0;
  std::uint32_t flags = 0;    // StepFlag, all ticks
  Doubt doubt = Doubt::None;  // of all ticks (RunTrust)
  double first_doubt_s = -1;  // < 0: none
  double expected_error = 0;  // of the largest force, as a share (RunTrust)
  std::int64_t restored_count = 0, let_go_count = 0;
  double largest_yield_m = 0;          // that the tool stayed behind hand or script; 0: it went where it was asked to
  double yielding_seconds = 0;         // for how long
  std::optional<FollowTotals> follow;  // where the cloud follows the tool; else report.json has no "follow"
  struct Device {
    std::int64_t poses = 0, silences = 0, fades = 0, refused = 0;
    double lowest_energy_J = 0, slipped_m = 0, lacking_s = 0;  // as DeviceReport's
  };
  std::optional<Device> device;  // that held the tool; else report.json has no "device"
  bool frozen = false;
  double setup_seconds = 0;
  std::string build;
};

/// @param volume_change  sum_q V_q (J_q - 1) / sum_q V_q, computed by the caller outside the loop
RunReport makeRunReport(const Model& model, const RunSummary& summary, const DeadlineStatistics& statistics,
                        int threads, double volume_change);

/// report.json: keys as the members; state_hash as 16 hex digits, flags as names;
/// numbers that are not finite become null.
std::string toJson(const RunReport& report);

/// Parts that other reports have, too: {p50, p99, p999, max}, ticks by cause, names of StepFlags.
nlohmann::ordered_json percentilesJson(const Percentiles& percentiles);
nlohmann::ordered_json lateTicksJson(const std::array<std::int64_t, kLateCauseCount>& late_ticks);
std::vector<std::string> flagNames(std::uint32_t flags);

}  // namespace palpate

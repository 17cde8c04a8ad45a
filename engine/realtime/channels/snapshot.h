#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/types.h"
#include "mechanics/materials/material.h"
#include "model/report.h"
#include "realtime/channels/tool_readings.h"

namespace palpate {

struct Model;
struct Place;

/// One tick's force, as written to force.csv and plotted.
struct ForceSample {
  std::int64_t tick = 0;
  std::int64_t wall_ns = 0;  // CLOCK_MONOTONIC when the tick began and took its input
  double time_s = 0;         // physics time
  double depth_m = 0;    // the skin under the tip, pressed from where it lay at rest; negative: gap in air (TrueDepth)
  double advance_m = 0;  // tip travel along the tool's axis at rest past first touch of the resting skin
  Vec3 force_raw = Vec3::Zero();       // N, on the tool
  Vec3 force_filtered = Vec3::Zero();  // N
  Doubt doubt = Doubt::None;           // why the force should not be believed
  double expected_error = 0;           // of forces, as a share, of late, and the force, N, that it was found for
  double error_force = 0;              // (step/resolution.h);
  int error_by = -1;                   // whose, as StepReport's
  Pose tool_pose;                      // of the tool that the tissue felt
  Vec3 torque = Vec3::Zero();          // N m, on the tool about its tip, raw
  Vec3 contact_normal = Vec3::Zero();  // unit, from the tissue towards the tool; 0: no contact
  double stiffness = 0;                // N/m, along the normal (ContactTrend); 0: not known
  double work_J = 0;                   // that the tool has done on the tissue (ContactTrend)
  std::uint64_t pose_sequence = 0;     // of the hand's pose that this tick took (HandSlot)
  std::int64_t loss_count = 0;         // times that the solution was lost and the tissue went back
  int contact_count = 0;               // points of the skin that carry force
  std::array<std::array<float, 3>, max_rigid_bodies> rigid_force{};  // N, of each rigid body on the tissue
  bool frozen = false;                                               // the watchdog stopped the tissue
  int node_count = 0;       // of the place, where the cloud follows the tool; else 0
  bool place_late = false;  // it is not the one for where the tools are: that was not ready
};

/// How well the loop holds its rate, up to the present tick.
struct LoopStatus {
  std::int64_t ticks = 0;
  std::int64_t overrun_count = 0;
  std::int64_t caught_up_count = 0;  // late ticks that were made good
  std::int64_t longest_overrun_streak = 0;
  double realtime_factor = 1;         // physics time / wall time since start or last resume
  double recent_realtime_factor = 1;  // over about the last second
  bool paused = false;
  bool frozen = false;              // the watchdog stopped the tissue; reset is offered
  std::int64_t restored_count = 0;  // times that the tissue was lost and went back to an earlier state
  std::int64_t undo_count = 0;
  std::int64_t reset_tick = 0;  // of the run, when it was last reset: forces of ticks up to it are of an earlier life
};

/// What the loop hands to whoever draws: a whole, consistent tick.
struct Snapshot {
  std::int64_t tick = 0;
  double time_s = 0;
  AlignedVector<Float4> u;             // (node_count) m
  std::shared_ptr<const Place> place;  // whose nodes these are, where the cloud follows the tool; else null
  Pose goal_pose;      // where the viewer's requests have led the hand, which follows smoothly (ToolTrack)
  Pose hand_pose;      // where the tool would be if it did not yield (ToolProxy)
  double yield_m = 0;  // by how much it does
  ForceSample force;
  ToolReadings tools;  // from the start on
  StepReport report;   // of that tick
  LoopStatus status;
  int contact_count = 0;              // entries used below for vertices,
  int contact_entries = 0;            // and in all: the others are samples' shares (tool_contact.h)
  std::vector<int> contact_vertex;    // (capacity) skin vertices in contact
  std::vector<Float4> contact_force;  // (capacity) N, on the tissue
  std::vector<Material> materials;    // (material_count) those in force; live changes show here

  Pose toolPose() const { return tools.posture(0).pose; }
};

/// The model that a snapshot's nodes are of. @param loaded  that the loop was made for
const Model& modelOf(const Snapshot& snapshot, const Model& loaded);

}  // namespace palpate

#pragma once

#include <atomic>
#include <cstdint>

#include "base/types.h"
#include "contact/contact_state.h"
#include "mechanics/relaxation.h"
#include "simulation/energy_balance.h"
#include "simulation/live_parameters.h"
#include "simulation/report.h"

namespace palpate {

/// What a viewer, script or replay asks of one tick.
struct Command {
  Pose tool_target;                         // where the tool should be at the end of the tick
  int pull_vertex = -1;                     // skin vertex pulled by a spring; -1: none
  Vec3 pull_target = Vec3::Zero();          // m, world
  const std::atomic<bool>* stop = nullptr;  // once true, the tick ends after the present step; null: never
};

/// All that changes during a run, live settings too. Equal states of one model give equal futures, bit for bit.
struct State {
  std::int64_t tick = 0;        // ticks done
  std::int64_t step = 0;        // steps of dt done; physics time is step * dt
  AlignedVector<Float4> u;      // (node_count) displacement parameters, m
  AlignedVector<Float4> du;     // (node_count) last step's increment, m
  AlignedVector<Float4> u_low;  // (node_count) what float32 lost of u (Kahan), m
  Pose tool_pose;
  ContactState contact;
  RelaxationHistory relaxation;  // of materials that relax; empty where none does
  LiveParameters live;
  EnergyBalance energy;  // watches; nothing depends on it
};

}  // namespace palpate

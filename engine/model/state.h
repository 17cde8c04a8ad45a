#pragma once

#include <cstdint>

#include "base/types.h"
#include "contact/contact_state.h"
#include "contact/rigid_bodies.h"
#include "contact/skin_contact.h"
#include "contact/tool_set.h"
#include "mechanics/relaxation.h"
#include "model/energy_balance.h"
#include "model/live_parameters.h"
#include "model/place_index.h"
#include "model/report.h"

namespace palpate {

/// What a viewer, script or replay asks of one tick.
struct Command {
  ToolPostures tools;                     // where they should be at the end of the tick
  bool moves_others = false;              // else all but the first stay where they are, and jaws as open as they are
  std::array<bool, max_tools> lets_go{};  // it touches no tissue
  int pull_vertex = -1;                   // skin vertex pulled by a spring; -1: none
  Vec3 pull_target = Vec3::Zero();        // m, world
};

/// Mass that was added where the tissue is squeezed (followStiffness).
struct LocalMass {
  AlignedVector<float> factor;  // (node_count) of the model's masses, at least 1
  bool active = false;          // some factor is above 1
  // What the report watches it by; nothing depends on them.
  Vec3 momentum = Vec3::Zero();  // kg m/s of the added mass, smoothed
  double force = 0;              // N, the largest recent force of tool or base
};

/// All that changes during a run, live settings too. Equal states of one model give equal futures, bit for bit.
struct State {
  std::int64_t tick = 0;        // ticks done
  std::int64_t step = 0;        // steps of dt done; physics time is step * dt
  PlaceIndex place = no_place;  // whose nodes these are, where the cloud follows the tool
  AlignedVector<Float4> u;      // (node_count) displacement parameters, m
  AlignedVector<Float4> du;     // (node_count) last step's increment, m
  AlignedVector<Float4> u_low;  // (node_count) what float32 lost of u (Kahan), m
  std::vector<ToolPosture> tool = std::vector<ToolPosture>(1);       // (tool_count) where each is
  std::vector<ContactState> contact = std::vector<ContactState>(1);  // (body_count) of the tools' bodies
  SkinContactState skins;                                            // empty where there is one body
  RigidState rigid;                                                  // empty without rigid bodies
  RelaxationHistory relaxation;                                      // of materials that relax; empty where none does
  LiveParameters live;
  BoundaryShifts region_shift;  // how far regions have come of what LiveLoads wants
  LocalMass local_mass;
  EnergyBalance energy;  // watches; nothing depends on it
};

}  // namespace palpate

#pragma once

#include <vector>

#include "base/types.h"
#include "contact/skin.h"
#include "contact/tool.h"

namespace palpate {

/// One skin vertex in solveContact's system.
struct ContactRow {
  Eigen::Vector4f normal;          // unit, outward from the tool, world
  Eigen::Vector4f predicted;       // increment of the vertex before contact, m
  Eigen::Vector4f tool_increment;  // of the tool's surface at the vertex, m
  Eigen::Vector4f stick;           // tangential force carried over from the last step, N
  Eigen::Vector4f force;           // on the tissue, N
  float gap = 0;                   // m, at the end of the step if there were no contact
  float stiffness = 0;             // N/m, of the contact layer at this vertex
  float mobility = 0;              // m/N, alpha sum_i N_i^2 / m_i
  float penetration = 0;           // m, after the last sweep
  int slot = 0;                    // index in ContactState
  int vertex = 0;                  // skin vertex
};

/// Forces between tool and tissue in one step, and what the solver remembers.
/// Sized by makeContactState at load; nothing here allocates later.
struct ContactState {
  int count = 0;               // vertices in or near contact
  std::vector<int> vertex;     // (capacity) skin vertex, ascending
  std::vector<Float4> force;   // (capacity) on the tissue at that vertex, N; warm start of the next step
  std::vector<Vec3f> normal;   // (capacity) side of the tool that it touches, tool's frame; 0: none
  bool overflow = false;       // more vertices near the tool than capacity; the farthest were dropped
  double max_penetration = 0;  // m, deepest after the last step
  int contact_count = 0;       // vertices that carry force after the last step
  int sweep_count = 0;         // sweeps of the last step

  // Scratch.
  struct Candidate {
    double distance = 0;  // m, to the tool
    int vertex = 0;
  };
  std::vector<Candidate> candidate;  // (capacity)
  std::vector<Float4> old_force;     // (capacity)
  std::vector<Vec3f> old_normal;     // (capacity)
  std::vector<int> old_vertex;       // (capacity)
  std::vector<ContactRow> row;       // (capacity)
};

/// Memory for the largest contact that this tool can make with this skin: every vertex, but no
/// more than 4096 (a tool of radius R over a skin with edges of 0.1 R touches about 750 at a time).
ContactState makeContactState(const SkinModel& skin, const ToolShape& tool);

}  // namespace palpate

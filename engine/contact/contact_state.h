#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "contact/contact_row.h"
#include "contact/skin.h"
#include "contact/tool.h"

namespace palpate {

/// A point of the skin that follows some of its vertices: one itself, two of an edge, three of a face.
struct SkinPoint {
  int corners = 1;
  std::array<int, 3> vertex = {};    // (corners)
  std::array<float, 3> share = {1};  // (corners) sum 1
};

/// Contact points on edges and faces of the skin that are stretched (face_samples.h), and what is remembered of them.
struct FaceSamples {
  // Remembered from step to step.
  int count = 0;
  std::vector<int> id;        // (capacity) edge or face and place on it, ascending
  std::vector<Float4> force;  // (capacity) on the tissue, N
  std::vector<Vec3f> normal;  // (capacity) as ContactState::normal
  std::vector<Vec3f> side;    // (capacity) as ContactState::side
  float longest_edge = 0;     // m, of the stretched faces near the tool, now; 0: none is stretched
  float largest_stretch = 1;  // of their edges

  // Of this tick.
  std::vector<SkinPoint> point;  // (capacity)
  std::vector<float> area;       // (capacity) m^2, share of the skin as it is now
  std::vector<float> lift;       // (capacity) m, added to the distance while a sample is being brought in
};

/// Forces between tool and tissue in one step, and what the solver remembers.
/// Sized by makeContactState at load; nothing here allocates later.
struct ContactState {
  int count = 0;               // vertices in or near contact
  std::vector<int> vertex;     // (capacity) skin vertex, ascending
  std::vector<Float4> force;   // (capacity) on the tissue at that vertex, N; warm start of the next step
  std::vector<Vec3f> normal;   // (capacity) side of the tool that it touches, tool's frame; 0: none
  std::vector<Vec3f> side;     // (capacity) while it is deep: the side by which it came in (tool_side.h); 0: not deep
  FaceSamples samples;         // the same for points of stretched faces
  bool overflow = false;       // more points near the tool than capacity; the farthest vertices were dropped
  double max_penetration = 0;  // m, deepest after the last step
  int contact_count = 0;       // vertices and samples that carry force after the last step
};

/// Memory for the largest contact that this tool can make with this skin: every vertex, but no
/// more than 8192 (a tool of radius R over a skin with edges of 0.1 R touches about 750 at a time), and 1024 samples
/// of stretched faces.
ContactState makeContactState(const SkinModel& skin, const ToolShape& tool);

/// A vertex or a sample before a tool.
struct ToolRow : ContactRow {
  int vertex = 0;  // of the skin; of a sample its first corner
  const SkinPoint* sample = nullptr;
};

/// What the contact of a body of a tool needs while it is found and solved, beside its state.
struct ContactScratch {
  explicit ContactScratch(const SkinModel& skin);

  struct Candidate {
    double distance = 0;  // m, to the tool
    int vertex = 0;
  };
  std::vector<Candidate> candidate;  // (capacity of vertices)
  struct SampleCandidate {
    int id = 0;
    SkinPoint point;
    float area = 0, lift = 0;
  };
  std::vector<SampleCandidate> sample;  // (2 capacity of samples)
  // What was remembered before a search, of vertices or of samples.
  std::vector<int> old_id;        // (larger capacity)
  std::vector<Float4> old_force;  // (larger capacity)
  std::vector<Vec3f> old_normal;  // (larger capacity)
  std::vector<Vec3f> old_side;    // (larger capacity)
  std::vector<Vec3f> position;    // (vertex_count) m, of the vertices that are marked
  std::vector<int> mark;          // (vertex_count) 0: position unknown, > 0: slot in ContactState + 1, -1: other
  std::vector<int> marked;        // (vertex_count) those with -1
  std::vector<ToolRow> row;       // (capacity of vertices and samples) of a step

  /// Keeps the first `count` of what vertices or samples remember.
  void keepOld(int count, const std::vector<int>& id, const std::vector<Float4>& force,
               const std::vector<Vec3f>& normal, const std::vector<Vec3f>& side);
};

}  // namespace palpate

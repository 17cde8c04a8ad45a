#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/types.h"
#include "contact/contact_row.h"
#include "contact/skin.h"
#include "discretization/nodes/spacing_field.h"

namespace palpate {

/// Bodies whose skins touch each other and themselves: constant.
struct SkinBodies {
  std::vector<int> body;        // (vertex_count) of the skin's vertices
  int count = 1;                // at most max_skin_bodies
  std::vector<int> organ;       // (count) that each body is of, for the caller
  std::vector<float> friction;  // (count) Coulomb coefficient; of two bodies the larger counts
  // (count) By how densely their vertices stand: of two bodies that touch, the vertices of the lower rank carry the
  // pressure, and the other's only what those miss.
  std::vector<int> rank;
  std::vector<Vec3> normal;  // (vertex_count) unit, at rest
  // (vertex_count) m^2 of the skin that each touches other bodies for (skinPoints); 0: others do. Within a body all do.
  std::vector<float> area;
  // Faces around the vertices of the skin's clusters.
  std::vector<int> cluster_face_begin;  // (cluster_count + 1)
  std::vector<int> cluster_face;
  std::vector<int> cluster_body;                // (cluster_count) of the clusters' vertices; -1: of several
  std::vector<std::array<int, 2>> across_gaps;  // clusters of one body, near each other at rest, that may yet touch
  double least_gap = 0;                         // m, at rest, between vertices that may touch
  std::vector<int> region;                      // (vertex_count) of the skin's clusters
  std::vector<int> region_node_begin;           // (region_count + 1)
  std::vector<int> region_node;                 // nodes that move each region's vertices, ascending
  int node_count = 0;                           // that move the skin
  double spacing = 0;                           // m, of the nodes
  double longest_edge = 0;                      // m, of the skin at rest
  double apart = 0;                             // m, between points that touch other bodies, or of an edge, at most
  double row_sum = 1;  // max_v sum_i |N_i(X_v)|: no vertex moves further than this times the fastest node

  bool several() const { return count > 1; }
};
constexpr int max_skin_bodies = 64, max_organs = 16;

/// The bodies of a skin, all of organ 0 and without friction, from where its vertices are at rest; then what follows
/// from its rows, which each place of a cloud that follows the tool has of its own.
/// @param spacing  m, of the nodes  @param finest  where they are the nearest to one another that they can be
SkinBodies makeSkinBodies(const SkinModel& skin, double spacing, const SpacingField& finest);
void addRows(const SkinModel& skin, SkinBodies& bodies);

/// Vertices of the skin that are near another body or another part of their own, with the face that each is before: the
/// side on which it is is remembered, found when it comes near and followed from face to face, so that what is pressed
/// through a thin part of another body finds its way back. Sized by makeSkinContactState; nothing here allocates later.
struct SkinContactState {
  int count = 0;
  std::vector<int> vertex;       // (capacity) ascending
  std::vector<int> face;         // (capacity) of another body, or another part
  std::vector<float> clearance;  // (capacity) m, at most what is between the two; -infinity: inside
  std::vector<Float4> force;     // (capacity) on the tissue at the vertex, N; the face has the opposite
  // While all parts that may touch are far from each other, the fastest vertex is watched; else each region is, and
  // looked at when it may have come near.
  bool calm = false;
  double travel = 0;          // m, that vertices have moved at most in this tick
  double since_calm = 0;      // m, by which parts have come nearer at most since they were seen to be far
  std::vector<float> moved;   // (region_count) m, that each region's vertices have moved at most in this tick,
  std::vector<float> unseen;  // (region_count) and before, since they were looked at; infinity: never
};
SkinContactState makeSkinContactState(const SkinBodies& bodies);

/// The pairs that may touch in a tick, and scratch.
struct SkinContactScratch {
  SkinContactScratch(const SkinBodies& bodies, const SkinModel& skin);

  struct Row : ContactRow {                           // slot: in SkinContactState
    int begin = 0, end = 0;                           // of its entries
    Eigen::Vector4f apart = Eigen::Vector4f::Zero();  // m, vertex less face point at rest
    float lift = 0;                                   // m, added to the gap
    float area = 0;                                   // m^2, that it stands for
  };
  int row_count = 0;
  bool overflow = false;    // more pairs than there is memory for; the last vertices' were left out
  std::vector<Row> row;     // (capacity)
  std::vector<int> active;  // (capacity) rows that touch in this step, or nearly
  // What a row's vertex has more of a node than its face point, N_i(X_v) - sum_k b_k N_i(X_k).
  std::vector<int> node;   // (entry_capacity)
  AlignedVector<float> N;  // (entry_capacity)

  // Of one look.
  std::uint32_t look = 0;
  std::vector<std::uint32_t> known, directed;  // (vertex_count) the look at which position and normal were found
  std::vector<Vec3> position;                  // (vertex_count) m
  std::vector<Vec3> normal;                    // (vertex_count) unit, of the faces around it
  std::vector<std::uint32_t> measured;         // (face_count) the look at which `area` was found
  std::vector<Vec3> area;                      // (face_count) m^2, twice the area along the normal
  struct Cluster {
    Vec3 centre = Vec3::Zero();  // m, of its representative
    double reach = 0;            // m, around it, where its vertices are for certain
    std::uint32_t look = 0;      // at which the radius was found
    std::uint32_t directed = 0;  // at which the axis was
    double radius = 0;           // m, around its centre
    Vec3 coming = Vec3::Zero();  // m, that its centre will move in a tick if it goes on as now,
    double uneven = 0;           // m, and by which its vertices will move otherwise at most
    Vec3 axis = Vec3::Zero();    // unit, mean of its faces' normals
    double spread = 0;           // rad, of the normals around it
  };
  std::vector<Cluster> cluster;  // (cluster_count) of the skin
  // Vertices of clusters, 16 to a block: x, y, z from the centre, m, then of the normal. Filled up with what is
  // far away.
  std::vector<int> block_begin;  // (cluster_count + 1)
  std::vector<std::array<std::array<float, 16>, 6>> block;
  std::vector<int> nearest;               // (vertex_count) vertex that each may touch; -1: none
  std::vector<double> nearest_distance2;  // (vertex_count) m^2
  std::vector<std::uint8_t> due;          // (region_count) it is looked at
  std::vector<int> old_vertex, old_face;
  std::vector<float> old_clearance;
  std::vector<Float4> old_force;
  std::vector<std::uint8_t> old_touches;
};

/// What the bodies do to each other in one step.
struct SkinContact {
  int count = 0;               // vertices that carry force
  double max_penetration = 0;  // m
  bool overflow = false;       // more pairs than there is memory for
};

/// Before a tick's steps: the pairs that may touch. Those regions of the skin are looked at that have moved so far that
/// others may be near; calm tissue pays nothing.
/// @param du     (node_count) m, that the nodes moved in the last step
/// @param steps  of a tick
/// Real-time: no allocation, no lock, no throw.
void findSkinPairs(const SkinBodies& bodies, const SkinModel& skin, const Float4* u, const Float4* du, int steps,
                   SkinContactState& state, SkinContactScratch& scratch);

/// Nothing touches, and nothing may in the coming tick: findSkinPairs would find none.
bool areCalm(const SkinBodies& bodies, const SkinContactState& state);

/// After a step.
/// @param distance  m, of the node that moved furthest
/// @param du        m, of all nodes
template <class Row>
void noteTravel(const SkinBodies& bodies, double distance, const Row* du, SkinContactState& state) {
  if (bodies.body.empty()) return;
  state.travel += distance * bodies.row_sum;
  if (state.calm) return;
  for (std::size_t r = 0; r < state.moved.size(); ++r) {
    auto furthest2 = decltype(du->x){0};
    for (int k = bodies.region_node_begin[r]; k < bodies.region_node_begin[r + 1]; ++k) {
      const Row& d = du[bodies.region_node[k]];
      furthest2 = std::max(furthest2, d.x * d.x + d.y * d.y + d.z * d.z);
    }
    state.moved[r] += static_cast<float>(bodies.row_sum * std::sqrt(furthest2));
  }
}

/// The force of all other organs on one, N.
Vec3 skinForceOn(const SkinBodies& bodies, const SkinModel& skin, int organ, const SkinContactState& state);

}  // namespace palpate

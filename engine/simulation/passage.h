#pragma once

#include <vector>

#include "approximation/shape_table.h"
#include "simulation/place.h"
#include "simulation/state.h"

namespace palpate {

/// The way from one place to another: how a state of A becomes one of B. The displacement field goes over,
///
///   sum_j N^B_j(X_i) u^B_j = u^A(X_i) = g_i   at the nodes X_i of B,
///
/// and so do its increments. Nodes that both places have with the same row of N (to same_place and same_N) keep their
/// parameters, bit for bit; only `node` is solved for, from what it has in common with A, by five sweeps
/// u_i += 1.2 (g_i - sum_j N^B_ij u_j), over all of `node` at once. With values for
/// parameters, as no sweeps would leave them, the force of a press jumps by 13 % (place_test.cpp).
struct Passage {
  std::vector<int> from;  // (node_count of B) the node of A that it is, or -1: new
  std::vector<int> node;  // (row_count) nodes of B whose rows are not those of A, ascending
  ShapeTable at;          // (row_count) N of A at X of these nodes
  ShapeTable own;         // (row_count) N of B there

  int newCount() const;
};

/// m, and of N: the volume is fitted place by place, and moves surface nodes around a ball by ever less. For them the
/// force of a press of half a radius changes by some 1e-4 of itself.
inline constexpr double same_place = 1e-6, same_N = 1e-4;
inline constexpr int passage_sweeps = 5;
inline constexpr double passage_relaxation = 1.2;

/// Throws std::runtime_error where a node of B lies where A has no approximation (they are not of one Places).
Passage makePassage(const Place& a, const Place& b);

/// Memory of applyPassage.
struct PassageScratch {
  explicit PassageScratch(const Passage& passage)
      : wanted(passage.node.size()), change(passage.node.size()), values(passage.from.size()) {}
  std::vector<Vec3> wanted, change;  // (row_count) m
  std::vector<Vec3> values;          // (node_count of B) m
};

/// Fills `state`, made by initialState(b.model), with a state of `a`: u, du and u_low by the passage; contact, tools,
/// skull as they are (one skin for all places); time, live friction, loads and materials; added mass node by node, new
/// nodes with the most of those that carried them. The energy balance starts anew.
/// Real-time: no allocation, no lock, no throw.
/// Test: simulation/place_test.cpp (linear fields, no change at equal places, force in the ticks after)
void applyPassage(const Place& a, const Place& b, const Passage& passage, const State& before, PassageScratch& scratch,
                  State& state);

}  // namespace palpate

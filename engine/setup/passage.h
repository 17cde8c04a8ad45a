#pragma once

#include <vector>

#include "approximation/shape_table.h"
#include "base/spin_team.h"
#include "model/state.h"
#include "setup/history_passage.h"
#include "setup/place.h"

namespace palpate {

/// The way from one place to another: how a state of A becomes one of B. The displacement field goes over,
///
///   sum_j N^B_j(X_i) u^B_j = u^A(X_i) = g_i   at the nodes X_i of B,
///
/// and so do its increments. Nodes that both places have with the same row of N (to same_place and same_N) keep their
/// parameters, bit for bit; only `node` is solved for, from what it has in common with A, by five sweeps
/// u_i += 1.2 (g_i - sum_j N^B_ij u_j), over all of `node` at once (of the change of u, in float). With values for
/// parameters, as no sweeps would leave them, the force of a press jumps by 13 % (place_test.cpp).
struct Passage {
  std::vector<int> from;   // (node_count of B) the node of A that it is, or -1: new
  std::vector<int> node;   // (row_count) nodes of B whose rows are not those of A, ascending
  ShapeTable at;           // (row_count) N of A at X of these nodes
  ShapeTable own;          // (row_count) N of B there
  HistoryPassage history;  // of points

  /// Rows of float weights, by numbers of nodes.
  struct Rows {
    std::vector<int> begin, node;  // (row_count + 1); (entry_count)
    std::vector<float> weight;     // (entry_count)

    void end() { begin.push_back(static_cast<int>(node.size())); }
  };
  // Computed by complete(), for the loop.
  std::vector<int> fresh;  // which of `node` are new, ascending
  Rows missing;  // (row_count) g_i - sum_j N^B_ij u_j, over A's nodes, then the new ones in the order of fresh
  Rows inner;    // (row_count) what `own` has between `node`, by their numbers there

  int newCount() const { return static_cast<int>(fresh.size()); }
  /// After `at` and `own`.
  void complete(int node_count_of_a);
};

/// m, and of N: the volume is fitted place by place, and moves surface nodes around a ball by ever less. For them the
/// force of a press of half a radius changes by some 1e-4 of itself.
inline constexpr double same_place = 1e-6, same_N = 1e-4;
inline constexpr int passage_sweeps = 5;
inline constexpr double passage_relaxation = 1.2;

/// Throws std::runtime_error where a node of B lies where A has no approximation (they are not of one Places).
Passage makePassage(const Place& a, const Place& b);

/// Live friction, loads and materials of a state of some place in one of b.
/// Real-time: no allocation, no lock, no throw.
void carryLive(const Model& b, const LiveParameters& before, LiveParameters& live);

/// Memory of applyPassage.
struct PassageScratch {
  using Both = Eigen::Matrix<float, 8, 1>;  // u and du, m, each in four
  PassageScratch(const Passage& passage, std::size_t node_count_of_a)
      : before(node_count_of_a + passage.fresh.size(), Both::Zero()),
        missing(passage.node.size(), Both::Zero()),
        change(missing),
        changed(missing) {}
  AlignedVector<Both> before;                    // (node_count of A + new nodes)
  AlignedVector<Both> missing, change, changed;  // (row_count)
};

/// Fills `state`, made by initialState(b.model), with a state of the place that the passage comes from: u, du and u_low
/// by the passage; contact, tools, rigid bodies as they are (one skin for all places); time, live friction, loads,
/// materials and how far regions have come; what points remember as HistoryPassage has it; added mass node by node, new
/// nodes with the most of those that carried them. The energy balance starts anew, but for what relaxation kept.
/// @param team  that shares the work, or null; the result does not depend on it
/// Real-time: no allocation, no lock, no throw.
/// Test: simulation/place_test.cpp (linear fields, no change at equal places, force in the ticks after)
void applyPassage(const Place& b, const Passage& passage, const State& before, PassageScratch& scratch, State& state,
                  SpinTeam* team = nullptr);

/// The same; what `before` has of contacts changes hands.
void applyPassage(const Place& b, const Passage& passage, State&& before, PassageScratch& scratch, State& state,
                  SpinTeam* team = nullptr);

/// What two states have of contacts changes hands: undoes what applyPassage did to `before`.
void swapContacts(State& a, State& b);

}  // namespace palpate

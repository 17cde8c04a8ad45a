#pragma once

#include <array>
#include <type_traits>
#include <vector>

#include "base/spin_team.h"
#include "base/types.h"
#include "mechanics/boundary_shifts.h"
#include "mechanics/essential_nodes.h"

namespace palpate {

/// Imposes the displacement field at boundary nodes exactly (paper eqs. 13-25):
///   du += M^-1 V A^-1 (du_bar - Phi du),   A = Phi M^-1 V
/// SEBCIEM lumps the tractions at the nodes, V = Phi^T (eq. 20); EBCIEM interpolates them linearly on the
/// boundary's facets and integrates, V_jk = sum_i Phi_j(s_i) N^k(s_i) w_i (eq. 17). A node that belongs to no
/// fully imposed facet carries a lumped traction with either method.
///
/// A is factored once as a sparse matrix (A = L U in an order with little fill-in); P = M^-1 V A^-1 of eq. 25 is never
/// formed. All boundaries of a component are imposed together, so that it is exact where supports overlap. Components
/// with the same nodes share one factor.
template <class Real>
struct EssentialBoundaryOf {
  template <class Value>
  struct Rows {  // compressed rows
    std::vector<int> begin{0}, column;
    AlignedVector<Value> value;
  };
  struct Set {
    std::array<Real, 4> mask{};                // 1 for the components that this set imposes
    std::vector<int> node;                     // (row_count) imposed node of each row, in elimination order
    std::vector<Vec3> X;                       // (row_count) m
    std::vector<std::array<int, 3>> boundary;  // (row_count) per component, as in ImposedNode; -1 outside the mask
    std::vector<std::array<int, 3>> whole;     // (row_count) the same for all components, whatever the mask
    std::vector<double> share;                 // (row_count) sum_j V_jk: 1, or int N^k dS in m^2
    std::vector<Vec3> centre;                  // (row_count) m, sum_j V_jk X_j / share: where the node's traction acts
    Rows<Real> phi, v;                         // row k: N_j(X_k); V_jk (v is empty where it equals phi)
    std::vector<int> touched;                  // (touched_count) nodes that the tractions act on
    Rows<Real> spread;                         // V by node: row t holds V_jk of node j = touched[t], columns k
    Rows<Real> l, u;                           // unit lower and upper factor without their diagonals
    AlignedVector<Real> inverse_pivot;         // (row_count) of U
  };
  std::vector<Set> sets;
  std::vector<BoundaryMotion> motions;
};
using EssentialBoundary = EssentialBoundaryOf<float>;

/// Force and moment (about the motion's axis_point, in the present configuration) of a boundary on the tissue.
struct Reaction {
  Vec3 force = Vec3::Zero();   // N
  Vec3 moment = Vec3::Zero();  // N m
};

/// Into so many parts the rows are divided; a part is computed by one thread.
constexpr int boundary_parts = 8;

template <class Real>
struct BoundaryScratchOf {
  std::vector<AlignedVector<Real4<Real>>> rhs;  // (set_count)(row_count); after a step alpha times the tractions T
  std::vector<AlignedVector<Real4<Real>>>
      drift;  // (set_count)(row_count) m, drift that the next step with increments corrects
  // Of a step that imposes twice: what the first time brought.
  std::vector<AlignedVector<Real4<Real>>> first;  // (set_count)(row_count) as rhs
  bool goes_on = false;
  std::vector<Mat3> rotation, rotation_before;  // (boundary_count) minus identity, at the step's end and start
  std::vector<Vec3> shift, shift_before;        // (boundary_count) m
  BoundaryShifts moved, moved_before;           // beside the motions at the step's end and start; the caller's
  std::vector<std::uint8_t> moves;              // (boundary_count) for either reason
  std::vector<Reaction> reaction;               // (boundary_count) of the last step, paper eq. 18
  std::array<std::vector<Reaction>, boundary_parts> part_reaction;  // the terms of its sum
};
using BoundaryScratch = BoundaryScratchOf<float>;

/// @param mass  kg (node_count)
/// Throws std::runtime_error naming the node when A is singular (coincident nodes).
template <class Real = float>
EssentialBoundaryOf<Real> makeEssentialBoundary(const EssentialNodes& essential, const std::vector<double>& mass);

template <class Real>
BoundaryScratchOf<Real> makeBoundaryScratch(const EssentialBoundaryOf<Real>& boundary);

/// Corrects `du` so that the field at the imposed nodes follows the motions to `time_s`, and from `moved_before` to
/// `moved` of `scratch`, and leaves every boundary's reaction there.
/// @param u  null: du is set to the motions' increment over [time_s - dt, time_s], the most exact in float32;
///           otherwise u + du is set to the whole displacement, so that no errors accumulate
/// @param alpha  of paper eq. 12, s^2
/// @return force of the boundaries that have no motion on the tissue, N
/// @param again  it will be called once more in this step, after what moves du further: tractions and reactions are
///               then those of both times
/// The team shares all but the triangular solutions; results do not depend on its size.
/// Real-time: no allocation, no lock, no throw.
template <class Real>
Vec3 imposeBoundary(const EssentialBoundaryOf<Real>& boundary, double time_s, double dt, double alpha,
                    const Real* inverse_mass, const std::type_identity_t<Real4<Real>>* u, Real4<Real>* du,
                    BoundaryScratchOf<Real>& scratch, SpinTeam& team, bool again = false);

/// Where only increments are imposed, their rounding errors add up to a drift of some 1e-9 of the body's size in a
/// thousand ticks. This function computes in double how far the field at the imposed nodes is from where it should be
/// at `time_s` with `moved` of `scratch`; the next imposeBoundary corrects a tenth of it. Called once per tick, it
/// keeps the drift at the size of one rounding error, however long the run.
/// @param u, u_low  displacement parameters and what float32 lost of them, m (node_count)
/// Real-time: no allocation, no lock, no throw.
void correctBoundaryDrift(const EssentialBoundary& boundary, double time_s, const Float4* u, const Float4* u_low,
                          BoundaryScratch& scratch);

/// Adds the force of each imposed node in the last step: share_k T_k, N. They sum to the boundaries' forces.
/// @param force  (node_count)
template <class Real>
void addNodeReactions(const EssentialBoundaryOf<Real>& boundary, const BoundaryScratchOf<Real>& scratch, double alpha,
                      std::vector<Vec3>& force);

}  // namespace palpate

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"

namespace palpate {

/// One imposed node: which components, and what motion.
struct ImposedNode {
  int node = 0;
  std::array<bool, 3> component{true, true, true};
  std::array<int, 3> motion{-1, -1, -1};  // per component: index into motions; -1: held at zero
};

/// A translation reached along the 3-4-5 polynomial.
struct BoundaryMotion {
  Vec3 translation = Vec3::Zero();  // m
  double duration = 0;              // s
};

/// Displacement of a motion at `time`: translation * (10 t^3 - 15 t^4 + 6 t^5), t = time/duration.
Vec3 motionAt(const BoundaryMotion& motion, double time_s);

/// Imposes the displacement field at boundary nodes exactly, as SEBCIEM does (paper eqs. 18-25):
///   du += M^-1 Phi^T A^-1 (du_bar - Phi du),   A = Phi M^-1 Phi^T
/// where row k of Phi holds N_j(X_k). A is factored sparsely once (A = L L^T); P = M^-1 Phi^T A^-1
/// of eq. 25 is never formed. Components with the same node set share one factor.
struct EssentialBoundary {
  struct Set {
    std::array<float, 4> mask{};          // 1 for the components that this set imposes
    std::vector<int> node;                // (row_count) imposed node of each row, in elimination order
    std::vector<std::array<int, 3>> motion;  // (row_count) per component: index into motions or -1
    bool moves = false;                   // any of them is not -1
    std::vector<int> phi_begin, phi_node; // Phi in compressed rows
    AlignedVector<float> phi;             // N_j(X_k)
    std::vector<int> l_begin, l_row;      // L in compressed columns, diagonal first
    AlignedVector<float> l;               // its diagonal entries are stored inverted
  };
  std::vector<Set> sets;
  std::vector<BoundaryMotion> motions;
};

struct BoundaryScratch {
  AlignedVector<Float4> rhs;              // (largest row_count)
};

/// @param boundary_shape  N at the imposed nodes' positions, one row per entry of `imposed`
/// @param mass            kg (node_count)
/// Throws std::runtime_error naming the node when A is singular (coincident nodes).
EssentialBoundary makeEssentialBoundary(const std::vector<ImposedNode>& imposed,
                                        const std::vector<BoundaryMotion>& motions,
                                        const ShapeTable& boundary_shape, const std::vector<double>& mass);

BoundaryScratch makeBoundaryScratch(const EssentialBoundary& boundary);

/// Corrects `du` so that the field's increment at the imposed nodes is that of the motions
/// between time_s - dt and time_s.
/// @return reaction of the held (not moving) components on the tissue, N: sum of A^-1 r / alpha (paper eq. 18)
/// Real-time: no allocation, no lock, no throw.
Vec3 imposeBoundary(const EssentialBoundary& boundary, double time_s, double dt, double alpha,
                    const float* inverse_mass, Float4* du, BoundaryScratch& scratch);

}  // namespace palpate

#pragma once

#include <vector>

#include "approximation/shape_table.h"
#include "mechanics/materials/material.h"
#include "mechanics/node_patch.h"

namespace palpate {

/// Largest stable step of the central difference method, dt = 2 / omega_max, for the body at rest.
/// Damping of the form c M does not change it; imposed nodes can only raise it.
struct CriticalTimeStep {
  double dt = 0;         // s, from the largest eigenvalue of M^-1 K (Lanczos, residual added: not optimistic)
  double dt_proven = 0;  // s, from a block Gershgorin row sum: a strict bound
  int worst_node = -1;   // row that sets the proven bound
  int iterations = 0;    // Lanczos steps
};

/// Row sums of a bound on the stiffness at rest, kg/s^2 (node_count):
///   sum_q |V_q| M |b_iq| sum_j |b_jq|,   omega^2 <= max_i row_i / m_i        (block Gershgorin)
/// with M of Material::waveModulus().
/// Used as fictitious masses in dynamic relaxation, the row sums give all nodes the same stable step.
std::vector<double> gershgorinRows(const ShapeTable& shape, const std::vector<double>& volume,
                                   const std::vector<int>& point_material, const std::vector<Material>& materials,
                                   std::size_t node_count);

/// K is the stiffness linearised at rest: sum_q V_q B^T C B with the C of each material, fibres under tension.
/// @param shape   gradients at the integration points, 1/m
/// @param volume  m^3 (point_count)
/// @param mass    kg (node_count)
/// @param patches of the points, or empty. Patches only lower the eigenvalues, so the proven bound ignores them
CriticalTimeStep criticalTimeStep(const ShapeTable& shape, const std::vector<double>& volume,
                                  const std::vector<int>& point_material, const std::vector<Material>& materials,
                                  const std::vector<double>& mass, const NodePatches& patches = {});

}  // namespace palpate

#pragma once

#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "mechanics/essential_boundary.h"
#include "mechanics/kernel_layout.h"

namespace palpate {

/// Mass that follows the stiffness of squeezed tissue, so that a time step chosen at rest stays stable.
///
/// Squeezed tissue is stiffer: waves across a squeeze see the modulus c(F) of squeezedModulus(), six times that at rest
/// where a free block has 0.4 of its height. The block Gershgorin row of node i (critical_time_step.h) then is
///   row_i(u) = sum_q V_q c_q |b_iq| sum_j |b_jq| = row_i r_i,   r_i a mean of c_q / c_q(rest) with weights of sum 1.
/// With masses m_i f_i, f_i >= r_i (share / limit)^2, the bound of the deformed body is no higher than (limit / share)^2
/// times that of the body at rest: dt is at most `limit` of the stable step where it was `share` of it at rest. The mean
/// is taken in two stages, so that it costs little: of the points around a node (by volume), then over nodes (by their
/// part in the row).
///
/// Test: mechanics/local_mass_test.cpp (against the largest eigenvalue of the tangent in squeezed bodies).
struct StiffnessMeans {
  std::vector<int> point_begin;       // (node_count + 1) entries of each node's points in
  std::vector<std::int32_t> point;    // places in KernelLayout::point, and
  AlignedVector<float> point_weight;  // their weights, of sum 1
  std::vector<int> node_begin;        // (node_count + 1) entries of the nodes that are in a node's row in
  std::vector<std::int32_t> node;     // their numbers, and
  AlignedVector<float> node_weight;   // their weights, of sum 1
  /// (node_count) 1 where tractions of an essential boundary act. These nodes have one factor f in common, the largest
  /// that any of them needs: P = M^-1 V A^-1 of the boundary does not change if all its masses are multiplied by the
  /// same number.
  std::vector<std::uint8_t> bounded;
  int first_bounded = -1;  // the first of them, or -1
};

/// @param point_cell  vertices of each point's cell (point_count)
/// @param shape, volume, point_material, materials  as in gershgorinRows
StiffnessMeans makeStiffnessMeans(const KernelLayout& layout, const ShapeTable& shape,
                                  const std::vector<std::array<int, 4>>& point_vertices,
                                  const std::vector<double>& volume, const std::vector<int>& point_material,
                                  const std::vector<Material>& materials, const EssentialBoundary& boundary);

/// Moduli of points for waves in the direction in which they are squeezed most:
///   c = K s^2 + mu J^(-2/3) (5/9 (1 + 2 s^3 / J^2) - 1/3),   K + 4/3 mu at rest
/// the largest eigenvalue of the acoustic tensor of a neo-Hookean solid, s being the largest singular value of cof F
/// and the two others equal. s comes from |cof F|^2 = s^2 + 2 J^2 / s, up to 0.3 % too large.
/// @param cofactor_norm2, J  |cof F|^2 and det F (count)
/// @param bulk, shear        K and mu, Pa, or shares of a modulus
/// @param modulus            as `bulk` (count)
/// Real-time.
void squeezedModulus(const float* cofactor_norm2, const float* J, int count, float bulk, float shear, float* modulus);

}  // namespace palpate

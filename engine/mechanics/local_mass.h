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
/// where a free neo-Hookean block has 0.4 of its height; stretched fibres may be stiffer by far. The block Gershgorin
/// row of node i (critical_time_step.h) then is
///   row_i(u) = sum_q V_q c_q |b_iq| sum_j |b_jq| = row_i r_i,   r_i a mean of c_q / c_q(rest) with weights of sum 1.
/// With masses m_i f_i, f_i >= r_i (share / limit)^2, the bound of the deformed body is no higher than (limit /
/// share)^2 times that of the body at rest: dt is at most `limit` of the stable step where it was `share` of it at
/// rest. The mean is taken in two stages, so that it costs little: of the points around a node (by volume), then over
/// nodes (by their part in the row).
///
/// Test: mechanics/local_mass_test.cpp (against the largest eigenvalue of the tangent in squeezed bodies).
struct StiffnessMeans {
  /// Rows of weights, each of sum 1.
  struct Rows {
    std::vector<int> begin{0};  // (row_count + 1) entries of
    std::vector<std::int32_t> index;
    AlignedVector<float> weight;
    /// Mean of values by a row's weights. Real-time.
    float mean(int row, const float* values) const;
  };
  Rows points;  // (node_count) places in KernelLayout::point of the points around each node
  Rows nodes;   // (node_count) nodes that are in each node's row
  /// Where little is squeezed little is computed: `group_size` nodes in a row at a time. Lists without weights.
  static constexpr int group_size = 16;
  struct Lists {
    std::vector<int> begin{0};
    std::vector<std::int32_t> index;
  };
  Lists batches;  // (group_count) batches of 16 points that a group's `points` are in
  Lists groups;   // (group_count) groups that a group's `nodes` are in
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

/// Bounds of the tangent moduli of a batch of 16 points, c = squeeze s^2 + other of PointStateOf. s comes from |cof
/// F|^2 = s^2 + 2 J^2 / s, as if the two other singular values of cof F were equal: up to 1 % too large where they are,
/// more where they differ, never too small.
/// @param cofactor_norm2, J  |cof F|^2 and det F (16)
/// @param squeeze, other     of the law, Pa (16)
/// @param modulus            Pa (16)
/// Real-time.
void squeezedModulus(const float* cofactor_norm2, const float* J, const float* squeeze, const float* other,
                     float* modulus);

/// Whether no point of a batch is squeezed by more than about 4 %: then s^2 is at most hardly_squeezed_s2.
bool hardlySqueezed(const float* cofactor_norm2, const float* J);
constexpr float hardly_squeezed_s2 = 1.17F;

}  // namespace palpate

#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "mechanics/materials/material.h"

namespace palpate {

/// Volume averaged over the patch of cells around each node, against volumetric locking.
///
///   theta_a = sum_q s_aq (J_q - 1),  s_aq = w_q l_a(x_q) / V_a,  V_a = sum_q w_q l_a(x_q)
///   volumetric energy  sum_a V_a K_a / 2 theta_a^2,   so at q the pressure is  p_q = sum_a l_a(x_q) K_a theta_a
///
/// instead of K (J_q - 1), with K_a = V_a / sum_q (w_q l_a / K_q). l_a is the linear coordinate of the cell's vertex a.
/// The energy depends only on a patch's mean dilatation, so neighbours that share nodes no longer force each point to
/// keep its own volume. By the Cauchy-Schwarz inequality, with K_a the harmonic mean of K, this energy is never above
/// the pointwise one: a step that is stable without patches is stable with them. This needs l_a > 0. A point that
/// samples two cells and lies outside its own (cell_pairs.h) has some l_a <= 0: these are set to a tiny positive value,
/// and all are scaled to a sum of 1.
struct NodePatches {
  std::vector<std::array<int, 4>> node;       // (point_count) vertices of the point's cell
  std::vector<std::array<double, 4>> weight;  // (point_count) l_a(x_q), summing to 1
  std::vector<double> volume;                 // (node_count) V_a, m^3; 0 for a node in no point's cell
  std::vector<double> bulk_modulus;           // (node_count) K_a, Pa: harmonic mean of the patch

  bool empty() const { return node.empty(); }
};

/// @param X, cells        nodes (m) and their tetrahedra
/// Test: mechanics/node_patch_test.cpp
/// @param point_X, volume integration points, m and m^3; point_cell: the cell of each
NodePatches makeNodePatches(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                            const std::vector<Vec3>& point_X, const std::vector<double>& volume,
                            const std::vector<int>& point_cell, const std::vector<int>& point_material,
                            const std::vector<Material>& materials);

/// theta_a of the nodes from the points' J - 1, in double.
std::vector<double> patchDilatation(const NodePatches& patches, const std::vector<double>& volume,
                                    const std::vector<double>& J_minus_1);

/// p_q of the points from a pressure of each node, sum_a l_a(x_q) p_a.
std::vector<double> pointPressure(const NodePatches& patches, const std::vector<double>& node_pressure);

/// p_q of the points from their J - 1, in double: what the fast kernel is held to.
std::vector<double> patchPressure(const NodePatches& patches, const std::vector<double>& volume,
                                  const std::vector<double>& J_minus_1);

}  // namespace palpate

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
///
/// Averaging smooths the pressure over about an edge, and leaves points' volumes to swing about their patches' means,
/// which shear alone resists: under pressure and at held edges the body gets too soft, the more so the finer the cloud.
/// It is needed only as far as K is large beside the shear modulus. So points keep a share o_q of their volumetric
/// energy for themselves, as Puso and Solberg (2006, A stabilized nodally integrated tetrahedral) have it; the patches
/// get the rest (w_q (1 - o_q) in place of w_q), and
///
///   p_q = o_q K_q (J_q - 1) + (1 - o_q) sum_a l_a(x_q) K_a theta_a
///
/// Each part is never above its share of the pointwise energy, so what is said of the step holds.
///
/// With o_q K_q of 2.25 shear moduli instead of 0, the bonded box of 13,250 nodes pressed by 20 % answers with 0.9
/// instead of 1.8 % too little force, the half-ellipsoid of 7,799 nodes with 0.6 instead of 1.4 %; free blocks of nu
/// 0.49 keep to the closed form to 50 %. It is the most that makes no pressure in `mtled verify locking` rougher by a
/// tenth; with all of K the box is 4 % too stiff.
struct NodePatches {
  std::vector<std::array<int, 4>> node;       // (point_count) patches of the point: vertices of its cell
  std::vector<std::array<double, 4>> weight;  // (point_count) (1 - o_q) l_a(x_q), summing to 1 - o_q
  std::vector<double> own;                    // (point_count) o_q; empty: all are 0
  std::vector<double> volume;        // (vertex_count) V_a of the averaged shares, m^3; 0 for a node in no point's cell
  std::vector<double> bulk_modulus;  // (vertex_count) K_a, Pa: harmonic mean of the patch

  bool empty() const { return node.empty(); }
};

/// @param X, cells        vertices (m) and their tetrahedra: nodes, and where materials meet one more for each further
///                        side (sharp_interfaces.h)
/// Test: mechanics/node_patch_test.cpp
/// @param point_X, volume integration points, m and m^3; point_cell: the cell of each
/// @param own_bulk        of each point's bulk modulus what is not averaged, in shear moduli (what relaxes left out);
///                        0: all is
NodePatches makeNodePatches(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                            const std::vector<Vec3>& point_X, const std::vector<double>& volume,
                            const std::vector<int>& point_cell, const std::vector<int>& point_material,
                            const std::vector<Material>& materials, double own_bulk = 0);

/// theta_a of the nodes from the points' J - 1, in double.
std::vector<double> patchDilatation(const NodePatches& patches, const std::vector<double>& volume,
                                    const std::vector<double>& J_minus_1);

/// The patches' part of p_q of the points from a pressure of each node.
std::vector<double> pointPressure(const NodePatches& patches, const std::vector<double>& node_pressure);

/// The same from their J - 1, in double: what the fast kernel is held to.
std::vector<double> patchPressure(const NodePatches& patches, const std::vector<double>& volume,
                                  const std::vector<double>& J_minus_1);

/// Adds the points' own part, o_q K_q (J_q - 1).
void addOwnPressure(const NodePatches& patches, const std::vector<int>& point_material,
                    const std::vector<Material>& materials, const std::vector<double>& J_minus_1,
                    std::vector<double>& pressure);

/// Which share of a node's patch is averaged, the mean over its points by l_a: exactly 1 where no point has an own one
/// (node_count).
std::vector<double> averagedShares(const NodePatches& patches);

}  // namespace palpate

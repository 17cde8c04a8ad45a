#pragma once

#include "discretization/gradients/boundary_points.h"
#include "simulation/approximate.h"
#include "simulation/interface_nodes.h"

namespace palpate {

/// Supports that end at borders between materials (Scene::sharp_interfaces). A point of one material has the nodes of
/// that material's cells in its support, those of the border among them, and no others. So each side reproduces a
/// linear field of its own, and a field that is linear on both sides with a kink at the border is exact; with supports
/// across the border the kink is smeared over their width, which stiffens.
///
/// The two sides' fields agree at the border as far as its nodes carry them. The gradients see to it that uniform
/// stresses on both sides with one traction across the border are in equilibrium: for each material m and node i
///
///   sum_{q in m} V_q gradN_i(X_q) = int_{outer faces of m} N_i n dS + int_{border of m} L_i n dS
///
/// with L_i the linear function of the border's faces: a third of their area at each of their nodes, the same from both
/// sides but for the sign.
///
/// Test: simulation/sharp_interfaces_test.cpp
struct SharpInterfaces {
  std::vector<MaterialBits> node;   // (node_count)
  std::vector<int> point_material;  // (point_count) of the points' cells

  /// Material by material: samples of its outer faces, and the area vectors of its border at the nodes, m^2.
  struct Side {
    int material = 0;
    int begin = 0, end = 0;  // of the samples
    std::vector<int> border_node;
    std::vector<Vec3> border_area;
  };
  std::vector<Side> sides;
  BoundaryPoints boundary;  // all sides' samples
};

/// @param lumped  not 0 at imposed nodes whose tractions are lumped there (boundaryPoints); (node_count)
SharpInterfaces sharpInterfaces(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                const std::vector<int>& cell_material, const std::vector<int>& node_material,
                                const std::vector<int>& point_cell, const std::vector<std::uint8_t>& lumped);

/// Corrects the gradients of each material's points on its own.
/// @param shape        of all points; gradN is changed
/// @param at_boundary  N at sharp.boundary
void correctGradients(const SharpInterfaces& sharp, ShapeTable& shape, const std::vector<Vec3>& point_X,
                      const std::vector<double>& volume, const std::vector<Vec3>& X, const ShapeTable& at_boundary,
                      double tolerance);

/// A bit for each place's material.
std::vector<MaterialBits> bitsOf(const std::vector<int>& material);

/// One bit of each node's: the approximation at nodes of a border is that of one side.
std::vector<MaterialBits> firstBits(const std::vector<MaterialBits>& bits);

}  // namespace palpate

#pragma once

#include <cstdint>

#include "discretization/gradients/boundary_points.h"
#include "setup/approximate.h"

namespace palpate {

/// Groups of cells as bits of a number.
using GroupBits = std::uint64_t;
constexpr int max_groups = 64;

/// Which cells share their supports. At first the cells of a material are a group; those of materials beyond the 64th
/// are of the first group, and a lump of cells with less than a handful of nodes is of the group around it: so few
/// carry no approximation of their own.
std::vector<int> cellGroups(const std::vector<std::array<int, 4>>& cells, const std::vector<Vec3>& centroid,
                            const std::vector<int>& cell_material);

/// Gives cells whose nodes do not carry an approximation to the groups around them: at each place the nearest cell of
/// the group, or the lump of cells that it belongs to where that is small.
void joinGroups(const std::vector<Unsupported>& places, const std::vector<std::array<int, 4>>& cells,
                const std::vector<Vec3>& centroid, std::vector<int>& group);

/// Supports that end at borders between materials (Formulation::sharp_interfaces). A point of one material has the
/// nodes of that material's cells in its support, those of the border among them, and no others (groups: cellGroups).
/// So each side reproduces a linear field of its own, and a field that is linear on both sides with a kink at the
/// border is exact; with supports across the border the kink is smeared over their width, which stiffens.
///
/// A border goes where its nodes' own parameters go, for both sides, and the sides' fields go through them (pinned
/// nodes, weight_function.h): without, they meet for linear displacements only, and what gapes between them elsewhere
/// is stiffness that is lacking. Squeezed balls with a core are 4.5 % off in the mean without, 1.2 % with; cores of
/// confined rods 3.1 and 0.5 % (`mtled verify matrix`). The gradients see to it that uniform stresses on both sides
/// with one traction across the border are in equilibrium: for each group m and node i
///
///   sum_{q in m} V_q gradN_i(X_q) = int_{outer faces of m} N_i n dS + int_{border of m} L_i n dS
///
/// with L_i the linear function of the border's faces: a third of their area at each of their nodes, the same from both
/// sides but for the sign.
///
/// Test: simulation/sharp_interfaces_test.cpp
struct SharpInterfaces {
  std::vector<GroupBits> node;   // (node_count) of which groups a node has cells: several at nodes of a border
  std::vector<int> point_group;  // (point_count) of the points' cells

  /// Group by group: samples of its outer faces, and the area vectors of its border at the nodes, m^2.
  struct Side {
    int group = 0;
    int begin = 0, end = 0;  // of the samples
    std::vector<int> border_node;
    std::vector<Vec3> border_area;
  };
  std::vector<Side> sides;
  BoundaryPoints boundary;       // all sides' samples
  std::vector<int> sample_node;  // (sample_count) the border's node that it is at, or -1

  /// Nodes at borders: themselves; others: -1 (node_count).
  std::vector<int> borderNodes() const;
};

/// A table with rows that are a node's parameter alone. @param node  of each row, or -1: it stays (row_count)
ShapeTable withOwnRows(const ShapeTable& table, const std::vector<int>& node);

/// @param node_group  (node_count) of nodes that have no cell
/// @param lumped, loaded  as imposed, loaded of boundaryPoints: of nodes whose tractions are lumped there (node_count)
SharpInterfaces sharpInterfaces(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                const std::vector<int>& cell_group, const std::vector<int>& node_group,
                                const std::vector<int>& point_cell, const std::vector<std::uint8_t>& lumped,
                                bool loaded);

/// Corrects the gradients of each group's points on its own.
/// @param shape        of all points; gradN is changed
/// @param at_boundary  N at sharp.boundary
void correctGradients(const SharpInterfaces& sharp, ShapeTable& shape, const std::vector<Vec3>& point_X,
                      const std::vector<double>& volume, const std::vector<Vec3>& X, const ShapeTable& at_boundary,
                      double tolerance);

/// A bit for each place's group.
std::vector<GroupBits> bitsOf(const std::vector<int>& group);

/// The vertices of cells whose volume is held (node_patch.h, cell_volume.h). A node of a border is a vertex of its own
/// for each group that it has cells of: the pressures of two sides are unlike as soon as their bulk moduli are, and a
/// mean over both would be neither's.
struct VolumeVertices {
  std::vector<int> side_node;             // (side_count) nodes of vertices node_count + k
  std::vector<GroupBits> group;           // (node_count + side_count) one bit of each
  std::vector<std::array<int, 4>> cells;  // (cell_count) by vertices
};

VolumeVertices volumeVertices(const std::vector<GroupBits>& node, const std::vector<std::array<int, 4>>& cells,
                              const std::vector<int>& cell_group);

}  // namespace palpate

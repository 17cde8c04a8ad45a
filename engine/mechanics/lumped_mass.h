#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Lumped masses: a quarter of each cell's mass to each of its vertices. (Row sums of the shape
/// functions would keep the total as well, but could be negative, as MMLS shape functions are in places.)
/// A node in no cell shares the mass of the nearest node that has mass, in equal parts with that node and
/// with other such nodes, so the total stays exact and every mass is > 0.
///
/// @param X             node positions, m                       (node_count)
/// @param cells         vertices                                (cell_count), at least one
/// @param cell_volume   m^3, > 0                                (cell_count)
/// @param cell_density  kg/m^3, > 0                             (cell_count)
/// @return kg, > 0                                              (node_count)
/// Test: mechanics/lumped_mass_test.cpp
std::vector<double> lumpedMass(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                               const std::vector<double>& cell_volume, const std::vector<double>& cell_density);

}  // namespace palpate

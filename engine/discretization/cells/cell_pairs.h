#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cells/integration_points.h"

namespace palpate {

/// Cells that share a face, joined in pairs: each cell's partner, or -1.
///
/// A sample that stands for a pair instead of a cell integrates the less exactly the more the pair's second moment
/// exceeds the cells' own, by V_1 V_2 / (V_1 + V_2) |c_1 - c_2|^2 (c: centroids, V: volumes). Pairs are taken in the order
/// of that over (V_1 + V_2)^(5/3), smallest first: the most compact, whatever their size, so that fine parts of a cloud
/// are thinned out as much as coarse ones. It ends where there are `cells_per_point` cells to a cell or pair, or no
/// cell is left with an unpaired neighbour of its own group.
///
/// @param group            (cell_count) cells of different groups are never joined, e.g. the material
/// @param cells_per_point  1 (no pairs) to 2 (all that can); anything else throws InputError
/// Equal for equal input. Test: discretization/cell_pairs_test.cpp
std::vector<int> pairCells(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                           double cells_per_point);

/// One integration point for each cell without a partner, at its centroid, and for each pair, at the centroid of both:
/// exact for linear functions. A pair's `cell` is the larger, in which or near which the point lies,
/// and `other_cell` the smaller.
IntegrationPoints makePairedPoints(const std::vector<Vec3>& X, const BackgroundCells& cells,
                                   const std::vector<int>& partner);

}  // namespace palpate

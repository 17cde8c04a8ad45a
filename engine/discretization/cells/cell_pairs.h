#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cells/integration_points.h"

namespace palpate {

/// Cells that share a face, joined in pairs: each cell's partner, or -1.
///
/// One sample for two cells is less exact the more the second moment of the pair exceeds the sum of the cells' own
/// second moments. The excess is V_1 V_2 / (V_1 + V_2) |c_1 - c_2|^2 (c: centroids, V: volumes). Cells are joined in
/// ascending order of this excess over (V_1 + V_2)^(5/3), that is, the most compact pairs first whatever their size, so
/// that fine parts of a cloud are thinned out as much as coarse ones. Joining ends when there are `cells_per_point`
/// cells per sample, or when no cell has an unpaired neighbour of its own group left.
///
/// @param group            (cell_count) cells of different groups are never joined, e.g. the material
/// @param cells_per_point  1 (no pairs) to 2 (as many pairs as possible); anything else throws InputError
/// Equal for equal input. Test: discretization/cells/cell_pairs_test.cpp
std::vector<int> pairCells(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                           double cells_per_point);

/// The largest excess over (V_1 + V_2)^(5/3), dimensionless, of the pairs that pairCells joins; 0: there are none.
double largestPairMoment(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                         double cells_per_point);

/// Joins in the same order all pairs up to a moment, however many. Whether two cells are joined then depends on the
/// cells around them alone: clouds that are the same in some part have the same pairs there.
std::vector<int> pairCellsUpTo(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                               double moment);

/// One integration point for each cell without a partner, at the cell's centroid, and one for each pair, at the
/// centroid of both cells: exact for linear functions. A pair's `cell` is the larger of the two, and the point lies in
/// it or near it; `other_cell` is the smaller.
IntegrationPoints makePairedPoints(const std::vector<Vec3>& X, const BackgroundCells& cells,
                                   const std::vector<int>& partner);

}  // namespace palpate

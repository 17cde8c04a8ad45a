#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Where the weak form is sampled, and how much of the body each sample stands for.
struct IntegrationPoints {
  std::vector<Vec3> X;         // (point_count) m
  std::vector<double> volume;  // (point_count) m^3, > 0
  std::vector<int> cell;       // (point_count) the cell it lies in
};

/// Integration points of tetrahedral cells, cell by cell.
///
///   1 point:  the centroid, exact for linear functions
///   4 points: a = 0.5854102 at one vertex, b = 0.1381966 at the others, weights 1/4, exact for
///             quadratics (a = (5 + 3 sqrt 5)/20, b = (5 - sqrt 5)/20; Hammer, Stroud 1956)
///
/// @param X                positions of the cells' vertices, m    (node_count)
/// @param cells            vertices                               (cell_count)
/// @param cell_volume      what a cell's points share, m^3        (cell_count)
/// @param points_per_cell  1 or 4; anything else throws InputError
/// The points' volumes of a cell sum to cell_volume exactly (a division by 4 does not round).
/// Test: discretization/integration_points_test.cpp
IntegrationPoints makeIntegrationPoints(const std::vector<Vec3>& X,
                                        const std::vector<std::array<int, 4>>& cells,
                                        const std::vector<double>& cell_volume, int points_per_cell);

}  // namespace palpate

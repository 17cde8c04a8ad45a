#pragma once

#include <array>
#include <vector>

#include "base/types.h"

namespace palpate {

/// Where the weak form is sampled, and how much of the body each sample stands for.
struct IntegrationPoints {
  std::vector<Vec3> X;         // (point_count) m
  std::vector<double> volume;  // (point_count) m^3, > 0; with 5 points per cell some are < 0
  std::vector<int> cell;       // (point_count) the cell that the point samples
  std::vector<int>
      other_cell;  // (point_count) a second cell that the point samples (cell_pairs.h), or -1; empty: no point has one
};

/// Quadrature of a tetrahedron by its centroid (first), by four points with barycentric coordinates `a` for one vertex
/// and `b` for each of the others (a + 3 b = 1), in the vertices' order, or by both.
struct CellRule {
  double centroid_share = 0;  // of the cell's volume; 0: not a point
  double corner_share = 0;    // of each of the four; 0: no points
  double a = 0, b = 0;

  /// Appends the points of a tetrahedron.
  /// @param corners  m
  void append(const std::array<Vec3, 4>& corners, double volume, int cell, IntegrationPoints& points) const;
};

/// The rule with the given number of points:
///
///   1: the centroid, exact for linear functions
///   4: a = 0.5854102, b = 0.1381966, shares 1/4, exact for quadratics
///      (a = (5 + 3 sqrt 5)/20, b = (5 - sqrt 5)/20; Hammer, Stroud 1956)
///   5: the centroid with share -4/5, and a = 1/2, b = 1/6 with shares 9/20; exact for cubics. For shape
///      functions, which are not polynomials, its negative volume makes it no better than 4 points. Code that
///      assumes positive volumes (bounds of the time step, weighted means) must allow for it.
///
/// Any other number throws InputError.
CellRule cellRule(int points_per_cell);

/// Integration points of tetrahedral cells, cell by cell.
///
/// @param X                positions of the cells' vertices, m    (node_count)
/// @param cells            vertices                               (cell_count)
/// @param cell_volume      sum of the volumes of a cell's points, m^3 (cell_count)
/// @param points_per_cell  1, 4 or 5; anything else throws InputError
/// The points' volumes of a cell sum to cell_volume: bit for bit with 1 or 4 points (a division by 4 does
/// not round), to 1e-15 of it with 5.
/// Test: discretization/cells/integration_points_test.cpp
IntegrationPoints makeIntegrationPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                        const std::vector<double>& cell_volume, int points_per_cell);

}  // namespace palpate

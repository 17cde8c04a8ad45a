#pragma once

#include <array>
#include <functional>
#include <vector>

#include "base/types.h"
#include "discretization/cells/integration_points.h"

namespace palpate {

struct AdaptiveOptions {
  double accuracy = 0.1;       // tau: largest relative error of a cell's integral, > 0
  int points_per_cell = 1;     // 1, 4 or 5 (integration_points.h)
  int division = 8;            // parts of a cell that fails: 2, 4 or 8 (cell_division.h)
  int max_depth = 4;           // how often a cell and its parts may be divided; division^max_depth <= 2^18
  int max_points = 2'000'000;  // more are refused: their shape functions would fill gigabytes
};

/// Integration points, and what the adaptive quadrature did to get them.
struct AdaptivePoints {
  IntegrationPoints points;  // cell by cell
  int divided_cells = 0;     // cells that were divided because they missed the accuracy
  int deepest = 0;           // the deepest level of division that was reached
  int limited_cells = 0;     // (sub-)cells at max_depth that miss the accuracy
  double worst_error = 0;    // largest relative error of a (sub-)cell; <= accuracy if limited_cells == 0
  /// Points at which f was not finite, m: their (sub-)cells are neither judged nor divided. With GradientEnergy the
  /// supports of these points are inadmissible; enlargeSupports (shape_functions.h) makes them large enough.
  std::vector<Vec3> not_finite;
};

/// The function whose integral over each cell must be accurate: takes a point in m, returns values in any unit.
using Integrand = std::function<Vec3(const Vec3&)>;

/// Adaptive quadrature over background cells (paper section 2.5; Joldes et al. 2015b).
///
///   Q   the rule's integral of f over the cell,  Q_i over each of its parts
///   e = max_c |Q_c - sum_i Q_ic| / |Q_c|         component by component
///   e <= accuracy: the cell keeps its own points (the parts only judged it);
///   otherwise each part is judged and divided in the same way, down to max_depth.
///
/// Component by component, as the paper writes it, and not by the norm of the vector: where nodes lie denser in one
/// direction, the component of that direction would hide the errors of the others, and each component affects a stress
/// of its own. Differences below 1e-14 of the integral of |f_c| are rounding and count as zero, so a component may be
/// zero everywhere. Cells at max_depth are judged as well, at the cost of one more division: limited_cells > 0 says
/// that the accuracy was not reached everywhere.
///
/// Each part of a cell gets an equal share of cell_volume. The volumes of a cell's points therefore sum to
/// cell_volume within 1e-12, even where cell_volume is not the volume that its vertices enclose.
///
/// @param X            positions of the cells' vertices, m    (node_count)
/// @param cells        vertices                               (cell_count)
/// @param cell_volume  sum of the volumes of a cell's points, m^3 (cell_count)
/// @param f            each thread calls a copy of its own, so it may keep scratch (gradient_energy.h)
/// Throws InputError for options out of range and where more than max_points are needed.
/// Set-up only, on all cores; the result does not depend on their number. Cost for each resulting point:
/// division^2 / (division - 1) evaluations of f: 4, 5.3 or 9.1.
/// Test: discretization/cells/adaptive_quadrature_test.cpp
AdaptivePoints makeAdaptivePoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                  const std::vector<double>& cell_volume, const AdaptiveOptions& options,
                                  const Integrand& f);

}  // namespace palpate

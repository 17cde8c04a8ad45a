#include "discretization/integration_points.h"

#include <cmath>
#include <string>

#include "base/input_error.h"

namespace palpate {

IntegrationPoints makeIntegrationPoints(const std::vector<Vec3>& X,
                                        const std::vector<std::array<int, 4>>& cells,
                                        const std::vector<double>& cell_volume, int points_per_cell) {
  if (points_per_cell != 1 && points_per_cell != 4) {
    throw InputError({}, "there is no rule with " + std::to_string(points_per_cell) + " points per cell",
                     "use 1 or 4");
  }
  const double a = (5 + 3 * std::sqrt(5.0)) / 20;
  const double b = (5 - std::sqrt(5.0)) / 20;

  IntegrationPoints points;
  const std::size_t count = cells.size() * points_per_cell;
  points.X.reserve(count);
  points.volume.reserve(count);
  points.cell.reserve(count);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& [i, j, k, l] = cells[c];
    const Vec3 sum = X[i] + X[j] + X[k] + X[l];
    for (int p = 0; p < points_per_cell; ++p) {
      points.X.push_back(points_per_cell == 1 ? Vec3(sum / 4) : Vec3(b * sum + (a - b) * X[cells[c][p]]));
      points.volume.push_back(cell_volume[c] / points_per_cell);
      points.cell.push_back(static_cast<int>(c));
    }
  }
  return points;
}

}  // namespace palpate

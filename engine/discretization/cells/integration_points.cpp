#include "discretization/cells/integration_points.h"

#include <cmath>
#include <string>

#include "base/input_error.h"

namespace palpate {

void CellRule::append(const std::array<Vec3, 4>& corners, double volume, int cell, IntegrationPoints& points) const {
  const Vec3 sum = corners[0] + corners[1] + corners[2] + corners[3];
  if (centroid_share != 0) {
    points.X.push_back(sum / 4);
    points.volume.push_back(volume * centroid_share);
    points.cell.push_back(cell);
  }
  if (corner_share == 0) return;
  for (const Vec3& corner : corners) {
    points.X.push_back(b * sum + (a - b) * corner);
    points.volume.push_back(volume * corner_share);
    points.cell.push_back(cell);
  }
}

CellRule cellRule(int points_per_cell) {
  switch (points_per_cell) {
    case 1:
      return {1, 0, 0, 0};
    case 4:
      return {0, 0.25, (5 + 3 * std::sqrt(5.0)) / 20, (5 - std::sqrt(5.0)) / 20};
    case 5:
      return {-0.8, 0.45, 1.0 / 2, 1.0 / 6};
    default:
      throw InputError({}, "there is no rule with " + std::to_string(points_per_cell) + " points per cell",
                       "use 1, 4 or 5");
  }
}

IntegrationPoints makeIntegrationPoints(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                        const std::vector<double>& cell_volume, int points_per_cell) {
  const CellRule rule = cellRule(points_per_cell);
  IntegrationPoints points;
  const std::size_t count = cells.size() * points_per_cell;
  points.X.reserve(count);
  points.volume.reserve(count);
  points.cell.reserve(count);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& [i, j, k, l] = cells[c];
    rule.append({X[i], X[j], X[k], X[l]}, cell_volume[c], static_cast<int>(c), points);
  }
  return points;
}

}  // namespace palpate

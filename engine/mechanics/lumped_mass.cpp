#include "mechanics/lumped_mass.h"

#include <limits>

namespace palpate {

std::vector<double> lumpedMass(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                               const std::vector<double>& cell_volume, const std::vector<double>& cell_density) {
  std::vector<double> mass(X.size(), 0.0);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    for (int i : cells[c]) mass[i] += cell_volume[c] * cell_density[c] / 4;
  }

  // Nodes in no cell are few (none in a sound cloud): a plain search is enough.
  std::vector<int> giver(X.size(), -1);
  std::vector<int> takers(X.size(), 0);
  for (std::size_t i = 0; i < X.size(); ++i) {
    if (mass[i] > 0) continue;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < X.size(); ++j) {
      const double distance = (X[j] - X[i]).squaredNorm();
      if (mass[j] > 0 && distance < nearest) {
        nearest = distance;
        giver[i] = static_cast<int>(j);
      }
    }
    if (giver[i] >= 0) ++takers[giver[i]];
  }
  for (std::size_t j = 0; j < X.size(); ++j) mass[j] /= 1 + takers[j];
  for (std::size_t i = 0; i < X.size(); ++i) {
    if (giver[i] >= 0) mass[i] = mass[giver[i]];
  }
  return mass;
}

}  // namespace palpate

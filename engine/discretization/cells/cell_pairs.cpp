#include "discretization/cells/cell_pairs.h"

#include <algorithm>
#include <cmath>

#include "base/input_error.h"
#include "base/number_text.h"

namespace palpate {
namespace {

Vec3 centroid(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  const auto& [a, b, c, d] = cell;
  return (X[a] + X[b] + X[c] + X[d]) / 4;
}

}  // namespace

std::vector<int> pairCells(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                           double cells_per_point) {
  if (!(cells_per_point >= 1 && cells_per_point <= 2))
    throw InputError({}, "there can't be " + shortest(cells_per_point) + " cells per point", "use 1 to 2");
  const int count = static_cast<int>(cells.cells.size());
  std::vector<int> partner(count, -1);
  int wanted = count - static_cast<int>(std::lround(count / cells_per_point));

  struct Pair {
    double moment;  // that joining adds, over the pair's volume^(5/3)
    int low, high;
  };
  std::vector<Pair> pairs;
  for (const auto& [low, high] : neighbouringCells(cells.cells)) {
    if (group[low] != group[high]) continue;
    const double V = cells.volume[low], W = cells.volume[high];
    const double distance2 = (centroid(X, cells.cells[low]) - centroid(X, cells.cells[high])).squaredNorm();
    pairs.push_back({V * W / (V + W) * distance2 / std::pow(V + W, 5.0 / 3), low, high});
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return a.moment != b.moment ? a.moment < b.moment : std::pair(a.low, a.high) < std::pair(b.low, b.high);
  });
  for (const Pair& pair : pairs) {
    if (wanted == 0) break;
    if (partner[pair.low] >= 0 || partner[pair.high] >= 0) continue;
    partner[pair.low] = pair.high;
    partner[pair.high] = pair.low;
    --wanted;
  }
  return partner;
}

IntegrationPoints makePairedPoints(const std::vector<Vec3>& X, const BackgroundCells& cells,
                                   const std::vector<int>& partner) {
  IntegrationPoints points;
  for (int c = 0; c < static_cast<int>(partner.size()); ++c) {
    const int other = partner[c];
    const double V = cells.volume[c], W = other < 0 ? 0 : cells.volume[other];
    if (other >= 0 && (W > V || (W == V && other < c))) continue;  // the other one's
    Vec3 x = centroid(X, cells.cells[c]);
    if (other >= 0) x += W / (V + W) * (centroid(X, cells.cells[other]) - x);
    points.X.push_back(x);
    points.volume.push_back(V + W);
    points.cell.push_back(c);
    points.other_cell.push_back(other);
  }
  return points;
}

}  // namespace palpate

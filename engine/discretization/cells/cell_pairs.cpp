#include "discretization/cells/cell_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/input_error.h"
#include "base/number_text.h"

namespace palpate {
namespace {

Vec3 centroid(const std::vector<Vec3>& X, const std::array<int, 4>& cell) {
  const auto& [a, b, c, d] = cell;
  return (X[a] + X[b] + X[c] + X[d]) / 4;
}

struct Pair {
  double moment;  // that joining adds, over the pair's volume^(5/3)
  int low, high;
};

/// Cells of one group that share a face, the most compact pair first.
std::vector<Pair> sortedPairs(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group) {
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
  return pairs;
}

/// Joins up to `wanted` pairs whose moment is at most `most`. @param largest  receives the largest moment joined
std::vector<int> join(const std::vector<Pair>& pairs, std::size_t cell_count, long wanted, double most,
                      double& largest) {
  std::vector<int> partner(cell_count, -1);
  largest = 0;
  for (const Pair& pair : pairs) {
    if (wanted == 0 || pair.moment > most) break;
    if (partner[pair.low] >= 0 || partner[pair.high] >= 0) continue;
    partner[pair.low] = pair.high;
    partner[pair.high] = pair.low;
    largest = pair.moment;
    --wanted;
  }
  return partner;
}

constexpr double any_moment = std::numeric_limits<double>::infinity();

std::vector<int> joinWanted(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                            double cells_per_point, double& largest) {
  if (!(cells_per_point >= 1 && cells_per_point <= 2))
    throw InputError({}, "there can't be " + shortest(cells_per_point) + " cells per point", "use 1 to 2");
  const long count = static_cast<long>(cells.cells.size());
  const long wanted = count - std::lround(static_cast<double>(count) / cells_per_point);
  return join(sortedPairs(X, cells, group), cells.cells.size(), wanted, any_moment, largest);
}

}  // namespace

std::vector<int> pairCells(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                           double cells_per_point) {
  double largest = 0;
  return joinWanted(X, cells, group, cells_per_point, largest);
}

double largestPairMoment(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                         double cells_per_point) {
  double largest = 0;
  joinWanted(X, cells, group, cells_per_point, largest);
  return largest;
}

std::vector<int> pairCellsUpTo(const std::vector<Vec3>& X, const BackgroundCells& cells, const std::vector<int>& group,
                               double moment) {
  double largest = 0;
  return join(sortedPairs(X, cells, group), cells.cells.size(), -1, moment, largest);
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

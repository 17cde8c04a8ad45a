#include "contact/skin_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace palpate {
namespace {

/// Points in cells, so that those near a place are found.
class PointCells {
 public:
  PointCells(const std::vector<Vec3>& X, double edge) : X_(X), edge_(edge) {}

  void add(int v) { cell_[at(X_[v])].push_back(v); }

  /// Calls use(point) for all within an edge of x, and some beyond.
  template <class Use>
  void forEachNear(const Vec3& x, const Use& use) const {
    const Cell middle = at(x);
    for (int n = 0; n < 27; ++n) {
      const auto cell = cell_.find({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
      if (cell == cell_.end()) continue;
      for (const int v : cell->second) use(v);
    }
  }

 private:
  using Cell = std::array<int, 3>;
  Cell at(const Vec3& x) const {
    Cell cell{};
    for (int a = 0; a < 3; ++a) cell[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(x[a] / edge_));
    return cell;
  }

  const std::vector<Vec3>& X_;
  double edge_;  // m
  std::map<Cell, std::vector<int>> cell_;
};

}  // namespace

SkinPoints skinPoints(const SkinModel& skin, const std::vector<int>& of_body,
                      const std::function<double(const Vec3&)>& apart) {
  const std::vector<Vec3>& X = skin.surface.vertices;
  std::vector<double> distance;
  for (const Vec3& x : X) distance.push_back(apart(x));
  PointCells cells(X, *std::max_element(distance.begin(), distance.end()));
  SkinPoints points;
  std::vector<int> number(X.size(), -1);
  for (int v = 0; v < static_cast<int>(X.size()); ++v) {
    bool free = true;
    cells.forEachNear(X[v], [&](int w) {
      if (of_body[w] == of_body[v] && (X[w] - X[v]).squaredNorm() < distance[v] * distance[v]) free = false;
    });
    if (!free) continue;
    cells.add(v);
    number[v] = static_cast<int>(points.vertex.size());
    points.vertex.push_back(v);
  }
  std::vector<double> area(points.vertex.size(), 0);
  for (std::size_t v = 0; v < X.size(); ++v) {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    cells.forEachNear(X[v], [&](int w) {
      const double d = (X[w] - X[v]).squaredNorm();
      if (of_body[w] == of_body[v] && d < least) least = d, nearest = number[w];
    });
    if (nearest >= 0) area[nearest] += skin.area[v];  // always: each vertex is nearer than `apart` to one
  }
  points.area.assign(area.begin(), area.end());
  return points;
}

}  // namespace palpate

#include "discretization/nodes/nested_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "base/parallel_for.h"
#include "discretization/nodes/site_grid.h"
#include "discretization/surface/surface_gaps.h"

namespace palpate {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr int inside = 3;
constexpr double on_feature = 0.2;  // spacings

double distanceToSegment(const Vec3& x, const Vec3& a, const Vec3& b) {
  const Vec3 along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((x - a).dot(along) / length2, 0.0, 1.0) : 0;
  return (a + t * along - x).norm();
}

/// Of each node the distance from the nearest one of lower dimension, m; infinity where there is none.
std::vector<double> distanceToLower(const std::vector<Vec3>& X, const std::vector<std::uint8_t>& dimension,
                                    double cell) {
  const Box3 box = boxOf(X);
  const double farthest = box.diagonal().norm();
  std::vector<double> distance(X.size(), infinity);
  for (int d = 1; d <= inside; ++d) {
    SiteGrid lower(box, cell);
    for (std::size_t i = 0; i < X.size(); ++i)
      if (dimension[i] < d) lower.add({X[i], Vec3::Zero(), 0});
    if (lower.size() == 0) continue;
    parallelFor(static_cast<int>(X.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        if (dimension[i] != d) continue;
        for (double radius = cell; distance[i] > radius && radius < 2 * farthest; radius *= 2)
          lower.forEachWithin(X[i], radius, [&](int, const Site& site) {
            distance[i] = std::min(distance[i], (site.X - X[i]).norm());
            return true;
          });
      }
    });
  }
  return distance;
}

}  // namespace

double spacingOfRadius(double r, double finest) {
  // Radius and spacing over the finest: a box and an ellipsoid whose live clouds have the mean cell edge, 1.03-1.06
  // spacings, of clouds made for that spacing.
  constexpr std::array<std::array<double, 2>, 7> measured = {
      {{0.78, 1}, {0.925, 1.25}, {0.975, 1.5}, {1.1, 1.75}, {1.3, 2}, {1.725, 2.5}, {2.1, 3}}};
  const double x = r / finest;
  if (x <= measured.front()[0]) return finest;
  for (std::size_t k = 1; k < measured.size(); ++k) {
    const auto& [x0, h0] = measured[k - 1];
    const auto& [x1, h1] = measured[k];
    if (x <= x1) return finest * (h0 + (h1 - h0) * (x - x0) / (x1 - x0));
  }
  return r * measured.back()[1] / measured.back()[0];
}

std::vector<std::uint8_t> nodeDimensions(const NodeCloud& cloud, const FeatureEdges& features,
                                         const SpacingField& spacing) {
  std::vector<std::uint8_t> dimension(cloud.X.size(), inside);
  parallelFor(static_cast<int>(cloud.X.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (!cloud.on_surface[i]) continue;
      const Vec3& x = cloud.X[i];
      const double range = on_feature * spacing.at(x);
      dimension[i] = 2;
      for (const auto& chain : features.chains)
        for (std::size_t k = 1; k < chain.points.size() && dimension[i] == 2; ++k)
          if (distanceToSegment(x, chain.points[k - 1], chain.points[k]) < range) dimension[i] = 1;
      for (const Vec3& corner : features.corners)
        if ((corner - x).norm() < range) dimension[i] = 0;
    }
  });
  return dimension;
}

std::vector<int> pairsAcrossAir(const NodeCloud& cloud, const SurfaceTree& surface, double widest) {
  const double rounding = 1e-6 * widest;
  SiteGrid grid(boxOf(cloud.X), widest);
  for (const Vec3& x : cloud.X) grid.add({x, Vec3::Zero(), 0});
  std::vector<int> across(cloud.X.size(), -1);
  parallelFor(static_cast<int>(cloud.X.size()), [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      if (!cloud.on_surface[i]) continue;
      for (const Vec3& at : acrossAir(surface, cloud.X[i], widest))
        grid.forEachWithin(at, rounding, [&](int j, const Site&) {
          if (j != i) across[i] = j;
          return across[i] < 0;
        });
    }
  });
  std::vector<int> pairs(cloud.X.size(), -1);
  for (int i = 0; i < static_cast<int>(across.size()); ++i) {
    const int j = across[i];
    if (j < 0 || pairs[i] >= 0 || pairs[j] >= 0) continue;
    pairs[i] = j;
    pairs[j] = i;
  }
  return pairs;
}

NestedCloud nestedOrder(const NodeCloud& cloud, std::vector<std::uint8_t> dimension, const SpacingField& finest,
                        const std::vector<int>& pairs) {
  const auto pairOf = [&](int i) { return pairs.empty() ? -1 : pairs[i]; };
  for (int i = 0; i < static_cast<int>(dimension.size()); ++i)
    if (pairOf(i) >= 0) dimension[i] = dimension[pairOf(i)] = std::min(dimension[i], dimension[pairOf(i)]);
  NestedCloud nested{cloud.X, cloud.on_surface, {}};
  const std::vector<Vec3>& X = nested.X;
  const double extent = boxOf(X).diagonal().norm();
  std::vector<double> room = distanceToLower(X, dimension, finest.smallest());
  for (double& r : room) r /= min_depth_share;
  for (std::size_t i = 0; i < X.size(); ++i)
    if (dimension[i] == 0) room[i] = infinity;

  // The node with the most room is next; it takes room from those around it. Room only shrinks, so entries of the queue
  // that are out of date are larger than what counts, and are passed over.
  using Entry = std::pair<double, int>;  // room, minus the node's number
  std::priority_queue<Entry> queue;
  SiteGrid grid(boxOf(X), finest.smallest());
  for (std::size_t i = 0; i < X.size(); ++i) {
    grid.add({X[i], Vec3::Zero(), 0});
    queue.emplace(room[i], -static_cast<int>(i));
  }
  nested.coarsest.assign(X.size(), 0);
  while (!queue.empty()) {
    const auto [r, minus] = queue.top();
    queue.pop();
    const int i = -minus;
    if (nested.coarsest[i] > 0 || r != room[i]) continue;
    const int pair = pairOf(i);
    if (pair >= 0 && room[pair] < r) {
      room[i] = room[pair];
      queue.emplace(room[i], -i);
      continue;
    }
    for (const int k : {i, pair})
      if (k >= 0) nested.coarsest[k] = spacingOfRadius(r, finest.at(X[i]));
    for (const int k : {i, pair}) {
      if (k < 0) continue;
      grid.forEachWithin(X[k], std::min(r, extent), [&](int j, const Site& site) {
        if (nested.coarsest[j] > 0 || dimension[j] < dimension[k]) return true;
        const double distance = (site.X - X[k]).norm();
        if (distance < room[j]) {
          room[j] = distance;
          queue.emplace(distance, -j);
        }
        return true;
      });
    }
  }
  return nested;
}

void keepLive(const std::vector<int>& members, int count, NestedCloud& cloud) {
  std::vector<int> first = members;
  std::stable_sort(first.begin(), first.end(), [&](int a, int b) { return cloud.coarsest[a] > cloud.coarsest[b]; });
  first.resize(std::min(first.size(), static_cast<std::size_t>(count)));
  for (const int i : first) cloud.coarsest[i] = infinity;
}

std::vector<int> liveNodes(const NestedCloud& cloud, const SpacingField& wanted) {
  std::vector<int> live;
  for (int i = 0; i < cloud.nodeCount(); ++i)
    if (cloud.coarsest[i] >= wanted.at(cloud.X[i])) live.push_back(i);
  return live;
}

}  // namespace palpate

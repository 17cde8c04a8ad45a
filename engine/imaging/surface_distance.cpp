#include "imaging/surface_distance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel_for.h"

namespace palpate {

SurfacePoints pointsOn(const TriangleSurface& surface, int count) {
  SurfacePoints points;
  std::vector<double> sum = {0};
  sum.reserve(surface.triangles.size() + 1);
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t)
    sum.push_back(sum.back() + areaVector(surface, t).norm());
  if (!(sum.back() > 0)) return points;
  for (int k = 0; k < count; ++k) {
    const double at = sum.back() * (k + 0.5) / count;
    const auto face = static_cast<std::size_t>(std::upper_bound(sum.begin() + 1, sum.end() - 1, at) - sum.begin() - 1);
    // Two irrational steps spread the points of a large face over it.
    const double r = std::sqrt(std::fmod(0.5 + k * 0.7548776662466927, 1.0));
    const double s = std::fmod(0.5 + k * 0.5698402909980532, 1.0);
    const auto& [a, b, c] = surface.triangles[face];
    points.x.push_back((1 - r) * surface.vertices[a] + r * (1 - s) * surface.vertices[b] + r * s * surface.vertices[c]);
    points.face.push_back(static_cast<int>(face));
  }
  return points;
}

double SurfaceDistance::shareBeyond(double distance) const {
  if (sorted.empty()) return 0;
  const auto beyond = sorted.end() - std::upper_bound(sorted.begin(), sorted.end(), distance);
  return static_cast<double>(beyond) / static_cast<double>(sorted.size());
}

SurfaceDistance distanceTo(const SurfaceTree& surface, const std::vector<Vec3>& points) {
  SurfaceDistance result;
  result.count = static_cast<int>(points.size());
  result.sorted.resize(points.size());
  parallelFor(result.count, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) result.sorted[k] = surface.closest(points[k]).distance;
  });
  if (points.empty()) return result;
  result.furthest =
      static_cast<int>(std::max_element(result.sorted.begin(), result.sorted.end()) - result.sorted.begin());
  std::sort(result.sorted.begin(), result.sorted.end());
  result.mean = std::accumulate(result.sorted.begin(), result.sorted.end(), 0.0) / result.count;
  result.p95 = result.sorted[static_cast<std::size_t>(0.95 * (result.count - 1))];
  result.max = result.sorted.back();
  return result;
}

}  // namespace palpate

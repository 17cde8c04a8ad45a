#include "contact/skin_points.h"

#include <algorithm>

#include "discretization/nodes/site_grid.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {

SkinPoints skinPoints(const SkinModel& skin, const std::vector<int>& of_body,
                      const std::function<double(const Vec3&)>& apart) {
  const std::vector<Vec3>& X = skin.surface.vertices;
  std::vector<double> distance;
  for (const Vec3& x : X) distance.push_back(apart(x));
  const double widest = distance.empty() ? 1 : *std::max_element(distance.begin(), distance.end());
  SiteGrid grid(boundingBox(skin.surface), widest);
  SkinPoints points;
  const auto isOf = [&](int point, std::size_t v) { return of_body[points.vertex[point]] == of_body[v]; };
  for (std::size_t v = 0; v < X.size(); ++v) {
    bool free = true;
    grid.forEachWithin(X[v], distance[v], [&](int p, const Site& site) {
      return free = !isOf(p, v) || (site.X - X[v]).squaredNorm() >= distance[v] * distance[v];
    });
    if (!free) continue;
    grid.add({X[v], Vec3::Zero(), 0});
    points.vertex.push_back(static_cast<int>(v));
  }
  std::vector<double> area(points.vertex.size(), 0);
  for (std::size_t v = 0; v < X.size(); ++v) {
    int nearest = -1;
    double least = widest * widest;  // each vertex is nearer than that to one
    grid.forEachWithin(X[v], widest, [&](int p, const Site& site) {
      if (const double d = (site.X - X[v]).squaredNorm(); d < least && isOf(p, v)) least = d, nearest = p;
      return true;
    });
    if (nearest >= 0) area[nearest] += skin.area[v];
  }
  points.area.assign(area.begin(), area.end());
  return points;
}

}  // namespace palpate

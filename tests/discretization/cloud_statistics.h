#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "discretization/nodes/node_cloud.h"
#include "discretization/nodes/site_grid.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {

/// How well a cloud keeps the spacing that was asked for.
struct CloudStatistics {
  double closest = 0;       // min over pairs of distance / h (h: mean of the two nodes' spacings)
  double mean_nearest = 0;  // mean over nodes of nearest distance / h
  double depth = 0;         // min over inner nodes of distance to the surface / h; infinity without any
};

inline CloudStatistics cloudStatistics(const NodeCloud& cloud, const SurfaceTree& surface,
                                       const SpacingField& spacing) {
  SiteGrid grid(boundingBox(surface.surface()), std::sqrt(spacing.smallest() * spacing.largest()));
  for (const Vec3& x : cloud.X) grid.add({x, Vec3::Zero(), spacing.at(x)});

  CloudStatistics statistics;
  statistics.closest = statistics.depth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cloud.X.size(); ++i) {
    const Vec3& x = cloud.X[i];
    const double h = spacing.at(x);
    double nearest = std::numeric_limits<double>::infinity();
    for (double radius = h; std::isinf(nearest) && radius < 1e3 * h; radius *= 2) {
      grid.forEachWithin(x, radius, [&](int j, const Site& other) {
        if (j != static_cast<int>(i)) nearest = std::min(nearest, (other.X - x).norm() * 2 / (h + other.h));
        return true;
      });
    }
    statistics.closest = std::min(statistics.closest, nearest);
    statistics.mean_nearest += nearest / static_cast<double>(cloud.X.size());
    if (!cloud.on_surface[i]) statistics.depth = std::min(statistics.depth, surface.closest(x).distance / h);
  }
  return statistics;
}

/// The same spacing everywhere, m.
inline SpacingField uniform(double h) {
  SpacingField field;
  field.spacing = h;
  return field;
}

}  // namespace palpate

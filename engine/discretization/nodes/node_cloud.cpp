#include "discretization/nodes/node_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "discretization/nodes/node_scatter.h"
#include "discretization/surface/surface_geometry.h"

namespace palpate {
namespace {

/// Beyond this the set-up takes minutes and gigabytes; far above what runs in real time (some ten thousand).
constexpr double max_nodes = 5e5;
/// A quadratic basis has ten functions; a cloud with fewer nodes can't support it anywhere.
constexpr std::size_t fewest_nodes = 10;

void checkAgainstBody(const SpacingField& spacing, const SurfaceTree& surface) {
  const Vec3 extent = boundingBox(surface.surface()).sizes();
  if (spacing.spacing > extent.minCoeff()) {
    std::ostringstream problem, advice;
    problem << "the node spacing " << spacing.spacing << " m is larger than the body's smallest extent "
            << extent.minCoeff() << " m";
    advice << "use less, best a quarter of it, " << extent.minCoeff() / 4 << " m, or check the surface's scale";
    throw InputError(spacing.place, problem.str(), advice.str());
  }
  const double volume = signedVolume(surface.surface());
  const auto refuse = [&](const SourceLocation& place, double h, double part) {
    const double nodes = part / (volume_per_node * h * h * h);
    if (nodes <= max_nodes) return;
    std::ostringstream problem, advice;
    problem << "the node spacing " << h << " m would need ";
    nodes < 1e15 ? problem << "about " << std::llround(nodes) : problem << "countless";
    problem << " nodes";
    advice << "use at least " << std::cbrt(part / (volume_per_node * max_nodes)) << " m, or check the surface's scale";
    throw InputError(place, problem.str(), advice.str());
  };
  refuse(spacing.place, spacing.spacing, volume);
  for (const SpacingField::Refinement& r : spacing.refinements) {
    refuse(r.place, r.spacing, std::min(volume, 4.0 / 3 * M_PI * std::pow(r.radius, 3)));
  }
}

}  // namespace

NodeCloud makeNodeCloud(const SurfaceTree& surface, const SpacingField& spacing, unsigned seed,
                        const std::vector<FeatureEdges::Chain>& rims, const std::function<void(double)>& progress) {
  spacing.check();
  checkAgainstBody(spacing, surface);

  FeatureEdges features = findFeatureEdges(surface.surface());
  features.chains.insert(features.chains.end(), rims.begin(), rims.end());
  Scatter scatter(surface, spacing, seed, progress);
  scatter.placeCorners(features);
  scatter.placeEdges(features);
  scatter.placeFaces();
  scatter.placeInside();

  NodeCloud cloud;
  for (const Site& site : scatter.sites()) {
    cloud.on_surface.push_back(cloud.X.size() < scatter.surfaceCount());
    cloud.X.push_back(site.X);
  }
  if (cloud.X.size() < fewest_nodes) {
    std::ostringstream problem;
    problem << "the node spacing " << spacing.spacing << " m leaves the body only " << cloud.X.size() << " nodes";
    throw InputError(spacing.place, problem.str(), "use a smaller spacing");
  }
  return cloud;
}

CloudStatistics cloudStatistics(const NodeCloud& cloud, const SurfaceTree& surface, const SpacingField& spacing) {
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

}  // namespace palpate

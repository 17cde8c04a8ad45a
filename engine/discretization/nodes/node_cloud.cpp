#include "discretization/nodes/node_cloud.h"

#include <algorithm>
#include <cmath>
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
                        const std::vector<FeatureEdges::Chain>& rims, const std::function<void(double)>& progress,
                        double paired_air) {
  spacing.check();
  checkAgainstBody(spacing, surface);

  FeatureEdges features = findFeatureEdges(surface.surface());
  features.chains.insert(features.chains.end(), rims.begin(), rims.end());
  Scatter scatter(surface, spacing, seed, progress);
  scatter.placeCorners(features);
  scatter.placeEdges(features);
  scatter.placeFaces();
  scatter.pairAcrossAir(paired_air);
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

}  // namespace palpate

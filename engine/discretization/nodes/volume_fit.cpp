#include "discretization/nodes/volume_fit.h"

#include <algorithm>
#include <cmath>

#include "base/parallel_for.h"
#include "discretization/surface/facet_rule.h"

namespace palpate {
namespace {

constexpr int iterations = 4;           // each leaves about a third of the gap
constexpr double farthest_move = 0.15;  // of the mean edge of the facets around a node
constexpr double min_volume = 0.2;      // of a cell's first volume
constexpr double flat_gap = 1e-9;       // of a facet's edge; below it is rounding
constexpr double widest_gap = 0.5;      // of a facet's edge; above it the facet does not follow the surface

struct Facet {
  std::array<int, 3> nodes;
  Vec3 normal;  // outward unit
  double area;  // m^2
  double edge;  // m, longest
};

Facet facetOf(const std::array<int, 3>& nodes, const std::vector<Vec3>& X) {
  const Vec3 &a = X[nodes[0]], &b = X[nodes[1]], &c = X[nodes[2]];
  const Vec3 area = (b - a).cross(c - a) / 2;
  return {nodes, area.normalized(), area.norm(),
          std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}))};
}

/// Directions that a node may still move in, as a projector, once those normal to flat faces are barred.
void bar(Mat3& free, const Vec3& normal) {
  const Vec3 left = free * normal;
  constexpr double parallel = 0.1;  // below it the normal repeats one that is barred, but for rounding
  if (left.norm() > parallel) free -= left.normalized() * left.normalized().transpose();
}

/// Mean height of the surface above the facet, m.
double meanGap(const Facet& facet, const std::vector<Vec3>& X, const SurfaceTree& surface) {
  double gap = 0;
  for (int k = 0; k < FacetRule::size; ++k)
    gap -= FacetRule::weight(k) *
           surface.signedDistance(FacetRule::point(k, X[facet.nodes[0]], X[facet.nodes[1]], X[facet.nodes[2]]));
  return gap;
}

/// The same of all facets.
std::vector<double> meanGaps(const std::vector<std::array<int, 3>>& facets, const std::vector<Vec3>& X,
                             const SurfaceTree& surface, SurfaceMemory* memory) {
  std::vector<double> gap(facets.size());
  const auto places = [&](int f) { return std::array{X[facets[f][0]], X[facets[f][1]], X[facets[f][2]]}; };
  parallelFor(static_cast<int>(facets.size()), [&](int first, int last) {
    for (int f = first; f < last; ++f) {
      const double* const known = memory ? memory->gap.find(places(f)) : nullptr;
      gap[f] = known ? *known : meanGap(facetOf(facets[f], X), X, surface);
    }
  });
  for (int f = 0; memory && f < static_cast<int>(facets.size()); ++f) memory->gap.keep(places(f), gap[f]);
  return gap;
}

}  // namespace

void holdShrinking(const BackgroundCells& cells, const std::vector<double>& first_volume, const std::vector<Vec3>& from,
                   std::vector<Vec3>& to) {
  BackgroundCells trial;
  trial.cells = cells.cells;
  for (bool again = true; again;) {
    again = false;
    updateVolumes(trial, to);
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
      if (trial.volume[c] >= min_volume * first_volume[c]) continue;
      for (const int i : cells.cells[c]) {
        again = again || to[i] != from[i];
        to[i] = from[i];
      }
    }
  }
}

void fitToVolume(NodeCloud& cloud, BackgroundCells& cells, const SurfaceTree& surface, SurfaceMemory* memory) {
  std::vector<std::array<int, 3>> facets = boundaryFacets(cells.cells);
  std::erase_if(facets, [&](const std::array<int, 3>& f) {
    return !cloud.on_surface[f[0]] || !cloud.on_surface[f[1]] || !cloud.on_surface[f[2]];
  });
  const std::vector<Vec3> start = cloud.X;
  const std::vector<double> start_volume = cells.volume;

  // Facets without a gap have no say later, but keep their nodes in their plane.
  std::vector<Mat3> free(start.size(), Mat3::Identity());
  const std::vector<double> first_gap = meanGaps(facets, start, surface, memory);
  std::vector<std::array<int, 3>> uneven;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const Facet facet = facetOf(facets[f], start);
    const double gap = std::abs(first_gap[f]) / facet.edge;
    for (int i : facets[f]) {
      if (gap < flat_gap) bar(free[i], facet.normal);
    }
    if (!(gap < flat_gap) && !(gap > widest_gap)) uneven.push_back(facets[f]);
  }
  facets = std::move(uneven);

  for (int iteration = 0; iteration < iterations; ++iteration) {
    // Each node goes the mean of its facets' gaps along their normals.
    std::vector<Vec3> move(start.size(), Vec3::Zero());
    std::vector<double> area(start.size(), 0.0), reach(start.size(), 0.0);
    const std::vector<double> gap = meanGaps(facets, cloud.X, surface, memory);
    for (std::size_t f = 0; f < facets.size(); ++f) {
      const Facet facet = facetOf(facets[f], cloud.X);
      for (int i : facets[f]) {
        move[i] += facet.area * gap[f] * (free[i] * facet.normal);
        reach[i] += facet.area * facet.edge;
        area[i] += facet.area;
      }
    }
    std::vector<Vec3> target = cloud.X;
    for (std::size_t i = 0; i < start.size(); ++i) {
      if (area[i] == 0) continue;
      const Vec3 total = cloud.X[i] + move[i] / area[i] - start[i];
      const double limit = farthest_move * reach[i] / area[i];
      target[i] = start[i] + total * std::min(1.0, limit / std::max(total.norm(), 1e-300));
    }
    holdShrinking(cells, start_volume, cloud.X, target);
    cloud.X = target;
  }
  updateVolumes(cells, cloud.X);
}

}  // namespace palpate

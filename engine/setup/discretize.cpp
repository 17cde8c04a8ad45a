#include "setup/discretize.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "contact/tool.h"
#include "discretization/nodes/node_order.h"
#include "discretization/nodes/node_scatter.h"
#include "discretization/nodes/volume_fit.h"
#include "discretization/surface/surface_geometry.h"
#include "scene/scene_messages.h"
#include "setup/discretize_parts.h"
#include "setup/interface_nodes.h"

namespace palpate {
namespace {

/// The longest edge of the skin, m: 0.35 of the radius of what touches it; of a tip sharper than a cone's own 0.7 in
/// proportion to touchRadius, or its vertices around the tip are too few, and it is pulled to the side.
double contactEdge(const Scene& scene) {
  constexpr double edge = 0.35, blunt = 1.2;
  double smallest = smallestToolRadius(scene);
  for (const ToolSpec& tool : scene.tools) smallest = std::min(smallest, blunt * touchRadius(tool.shape));
  return edge * smallest;
}

}  // namespace

SpacingField spacingField(const Scene& scene) {
  SpacingField spacing;
  spacing.spacing = scene.discretization.spacing;
  spacing.place = placeOf(scene, "discretization.spacing");
  for (const auto& r : scene.discretization.refine)
    spacing.refinements.push_back({r.centre, r.radius, r.spacing, r.blend, r.place});
  return spacing;
}

namespace {

/// Where the mantle of an imposed cylindrical region meets the organ's surface, so that the region ends at nodes: a
/// punch whose rim falls between nodes would be too small by half their distance. No curve where the rim leaves the
/// organ.
std::vector<FeatureEdges::Chain> rimsOf(const Scene& scene, const SurfaceTree& organ) {
  std::vector<FeatureEdges::Chain> rims;
  for (const auto& boundary : scene.boundaries) {
    const Region& region = boundary.region;
    if (region.kind != Region::Kind::Cylinder) continue;
    const int count =
        std::max(32, static_cast<int>(std::ceil(8 * 2 * M_PI * region.radius / scene.discretization.spacing)));
    const Vec3 e1 = region.normal.unitOrthogonal(), e2 = region.normal.cross(e1);
    FeatureEdges::Chain chain;
    chain.closed = true;
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * M_PI * k / count;
      // A hair inside, so that the nodes are in the region.
      const Vec3 arm = (region.radius - 1e-10) * (std::cos(angle) * e1 + std::sin(angle) * e2);
      const double past = 1e-3 * region.radius;  // beyond both ends
      const auto hit = organ.firstHit(region.point + arm + (region.height + past) * region.normal, -region.normal,
                                      region.height + 2 * past);
      if (!hit) break;
      chain.points.push_back(hit->point);
    }
    if (static_cast<int>(chain.points.size()) < count) continue;
    chain.points.push_back(chain.points.front());
    rims.push_back(std::move(chain));
  }
  return rims;
}

}  // namespace

double finestSpacing(double volume, double area, double nodes) {
  return std::max(std::cbrt(volume / (volume_per_node * nodes)), std::sqrt(area / (area_per_node * nodes)));
}

void checkCounts(const Scene& scene, double volume, double area) {
  // What the set-up can hold: about 0.1 MB a node. A typing error in the spacing should not fill the memory. A cloud
  // that follows the tool is no finer than can be made (followSizes).
  const double h = scene.discretization.spacing,
               nodes = std::max(volume / (volume_per_node * h * h * h), area / (area_per_node * h * h));
  if (!scene.discretization.follow && nodes > 1.001 * most_nodes)
    throw InputError(placeOf(scene, "discretization.spacing"),
                     "a spacing of " + number(scene.discretization.spacing) + " m makes " +
                         (nodes < 1e15 ? "about " + number(nodes) : "countless") + " nodes, more than " +
                         number(most_nodes),
                     "raise it, to " + number(finestSpacing(volume, area, most_nodes)) +
                         " m or more, and refine where the tool works");
  const double edge = contactEdge(scene), faces = area / (std::sqrt(3.0) / 4 * edge * edge);
  if (faces > max_refined_triangles)
    throw InputError(placeOf(scene, "tool.radius"),
                     "a tool with a radius of " + number(smallestToolRadius(scene)) + " m needs a skin of more than " +
                         number(faces) + " faces to touch; " + number(max_refined_triangles) + " are possible",
                     "raise it to " + number(smallestToolRadius(scene) * std::sqrt(2 * faces / max_refined_triangles)) +
                         " m, or is the organ's size right?");
}

Discretization discretizeOnSurface(const Scene& scene, const SurfaceTree& organ,
                                   const std::function<void(double)>& progress, double paired_air) {
  checkCounts(scene, signedVolume(organ.surface()), surfaceArea(organ.surface()));
  Discretization d;
  constexpr double of_nodes = 0.7;
  d.cloud = makeNodeCloud(
      organ, spacingField(scene), scene.discretization.seed, rimsOf(scene, organ),
      [&](double share) { progress(of_nodes * share); }, paired_air);
  if (hasBorders(scene)) putOnInterfaces(scene, organ, spacingField(scene), d.cloud);
  progress(of_nodes);
  d.cells = makeBackgroundCells(d.cloud, organ);
  constexpr int rounds = 4;  // most holes are closed by the first
  for (int k = 0; k < rounds && hasBorders(scene); ++k) {
    const Mended mended = closeInterfaces(scene, organ, spacingField(scene), d.cells.cells, d.cloud);
    if (mended.of_materials + mended.of_imposed == 0) break;
    d.cells = makeBackgroundCells(d.cloud, organ);
    if (mended.of_materials == 0) break;  // of the few that are left none is pierced by much
  }
  progress(0.95);
  return d;
}

FeatureEdges featuresOf(const Scene& scene, const SurfaceTree& organ) {
  FeatureEdges features = findFeatureEdges(organ.surface());
  const auto rims = rimsOf(scene, organ);
  features.chains.insert(features.chains.end(), rims.begin(), rims.end());
  return features;
}

void putInSlices(Discretization& d) {
  const auto order = slicedOrder(d.cloud.X, 4, 1);
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  d.cloud.X = reordered(d.cloud.X, order);
  d.cloud.on_surface = reordered(d.cloud.on_surface, order);
  for (auto& cell : d.cells.cells)
    for (int& node : cell) node = place[node];
}

void fitVolumes(const Scene& scene, const SurfaceTree& organ, Discretization& d, SurfaceMemory* memory) {
  fitToVolume(d.cloud, d.cells, organ, memory);
  if (hasSharpInterfaces(scene)) fitInterfaces(scene, organ, d.cloud, d.cells);
}

Discretization discretize(const Scene& scene, const SurfaceTree& organ, const std::function<void(double)>& progress) {
  Discretization d = discretizeOnSurface(scene, organ, progress);
  fitVolumes(scene, organ, d);
  putInSlices(d);
  return d;
}

TriangleSurface refineForContact(const Scene& scene, const TriangleSurface& organ, int max_triangles) {
  const SpacingField spacing = spacingField(scene);
  const double by_tool = contactEdge(scene);
  // What presses evenly is felt evenly only if the skin is no coarser than the nodes: a plate of 60 mm on a cube of 40
  // mm touched it at 13 places, and had 0.7 of its force.
  const auto longestEdge = [&](const Vec3& x) {
    const double h = spacing.at(x);
    return std::min(by_tool, h < scene.discretization.spacing ? h / 3 : h);
  };
  // At least so many: known at once, where refineSurface would need half a minute to find out.
  double faces = 0;
  for (std::size_t t = 0; t < organ.triangles.size(); ++t) {
    const auto& [a, b, c] = organ.triangles[t];
    const double edge = longestEdge((organ.vertices[a] + organ.vertices[b] + organ.vertices[c]) / 3);
    faces += areaVector(organ, static_cast<int>(t)).norm() / (std::sqrt(3.0) / 4 * edge * edge);
  }
  try {
    if (faces > max_triangles) throw std::length_error("");
    return refineSurface(organ, longestEdge, max_triangles);
  } catch (const std::length_error&) {
    const auto finest =
        std::min_element(scene.discretization.refine.begin(), scene.discretization.refine.end(),
                         [](const RefineSpec& a, const RefineSpec& b) { return a.spacing < b.spacing; });
    const bool finer = finest != scene.discretization.refine.end() && finest->spacing / 3 < by_tool;
    throw InputError(finer ? finest->place : placeOf(scene, "tool.radius"),
                     "the skin that the tool touches would have more than " + number(max_triangles) + " faces",
                     finer ? "raise this spacing of [[discretization.refine]], or tool.radius" : "raise tool.radius");
  }
}

std::vector<double> supportRadii(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                 double factor) {
  std::vector<double> sum(X.size(), 0);
  std::vector<int> count(X.size(), 0);
  for (const auto& cell : cells)
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b) {
        const double length = (X[cell[a]] - X[cell[b]]).norm();
        for (const int node : {cell[a], cell[b]}) {
          sum[node] += length;
          ++count[node];
        }
      }
  double total = 0;
  long total_count = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    total += sum[i];
    total_count += count[i];
  }
  for (std::size_t i = 0; i < sum.size(); ++i)
    sum[i] = factor * (count[i] > 0 ? sum[i] / count[i] : total / static_cast<double>(total_count));
  return sum;
}

}  // namespace palpate

#include "setup/prepare.h"

#include <algorithm>

#include "approximation/neighbours.h"
#include "base/parallel_for.h"
#include "discretization/gradients/boundary_points.h"
#include "discretization/gradients/consistent_gradients.h"
#include "mechanics/lumped_mass.h"
#include "mechanics/mass_scaling.h"
#include "mechanics/node_patch.h"
#include "scene/scene_regions.h"
#include "setup/approximate.h"
#include "setup/choose_time_step.h"
#include "setup/imposed_nodes.h"
#include "setup/interface_nodes.h"
#include "setup/mixtures.h"
#include "setup/sharp_interfaces.h"
#include "setup/thin_layers.h"

namespace palpate {
namespace {

/// materialAt of many places, on all cores.
std::vector<int> materialsAt(const Scene& scene, const std::vector<Vec3>& X, const SurfaceTree& tree) {
  std::vector<int> material(X.size());
  parallelFor(static_cast<int>(X.size()), [&](int first, int last) {
    for (int k = first; k < last; ++k) material[k] = materialAt(scene, X[k], tree);
  });
  return material;
}

/// Bits of the components in which lumped tractions act on nodes. Tractions that are integrated over facets can answer
/// any stress; lumped ones only a sum over the nodes.
std::vector<std::uint8_t> lumpedNodes(const Scene& scene, const EssentialNodes& essential, std::size_t node_count) {
  if (scene.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Ebciem)
    return std::vector<std::uint8_t>(node_count, 0);
  return imposedComponents(essential.nodes, node_count);
}

/// Samples of the organ's border at which gradients are made consistent.
BoundaryPoints consistencyPoints(const Scene& scene, const NodeCloud& cloud,
                                 const std::vector<std::array<int, 3>>& outer, const EssentialNodes& essential) {
  if (!scene.discretization.formulation.consistent_gradients) return {};
  return boundaryPoints(cloud.X, outer, lumpedNodes(scene, essential, cloud.X.size()), !scene.loads.empty());
}

/// The group of the cell that each place is in, as near as its middle tells: of the cells around the nearest of the
/// place's own material, where there is one.
std::vector<int> groupsAt(const Scene& scene, const SurfaceTree& tree, const std::vector<Vec3>& X,
                          const Neighbours& middles, const std::vector<int>& cell_material,
                          const std::vector<int>& cell_group) {
  constexpr int around = 8;
  const std::vector<int> material = materialsAt(scene, X, tree);
  std::vector<int> group(X.size());
  parallelFor(static_cast<int>(X.size()), [&](int first, int last) {
    for (int k = first; k < last; ++k) {
      const std::vector<int> cells = middles.nearest(X[k], std::min(around, static_cast<int>(cell_group.size())));
      const auto own = std::find_if(cells.begin(), cells.end(), [&](int c) { return cell_material[c] == material[k]; });
      group[k] = cell_group[own != cells.end() ? *own : cells.front()];
    }
  });
  return group;
}

/// Shape functions whose supports end at borders between materials, with the gradients of each side.
Approximation approximateSharply(const Scene& scene, const SurfaceTree& tree, const std::vector<Vec3>& X,
                                 const BackgroundCells& cells, const std::vector<int>& cell_material,
                                 const IntegrationPoints& points, const std::vector<Vec3>& skin_X,
                                 const std::vector<Vec3>& facet_X, const std::vector<double>& radius,
                                 const SurfaceGaps& gaps, double gradient_tolerance, const RowMemory* memory,
                                 Preparation& p) {
  const std::vector<Vec3> middle = centroids(X, cells.cells);
  const Neighbours middles(middle, std::vector<double>(middle.size(), scene.discretization.spacing));
  const auto lumped = lumpedNodes(scene, p.essential, X.size());
  std::vector<int> group = cellGroups(cells.cells, middle, cell_material);
  for (int attempt = 0;; ++attempt) {
    const auto at = [&](const std::vector<Vec3>& places) {
      return groupsAt(scene, tree, places, middles, cell_material, group);
    };
    const SharpInterfaces sharp =
        sharpInterfaces(X, cells.cells, group, at(X), points.cell, lumped, !scene.loads.empty());
    VolumeVertices vertices = volumeVertices(sharp.node, cells.cells, group);
    ApproximationGroups groups;
    groups.of_nodes = sharp.node;
    groups.points = bitsOf(sharp.point_group);
    groups.skin = bitsOf(at(skin_X));
    groups.nodes.assign(vertices.group.begin(), vertices.group.begin() + static_cast<std::ptrdiff_t>(X.size()));
    groups.facets = bitsOf(at(facet_X));
    for (const SharpInterfaces::Side& side : sharp.sides)
      groups.boundary.resize(static_cast<std::size_t>(side.end), GroupBits{1} << side.group);
    constexpr int patience = 8;  // rounds in which cells may join their neighbours
    std::vector<Unsupported> unsupported;
    Approximation shape = approximate(scene, X, radius, points.X, skin_X, facet_X, sharp.boundary.X, gaps, cells.cells,
                                      groups, attempt < patience ? &unsupported : nullptr, memory);
    if (!unsupported.empty()) {
      joinGroups(unsupported, cells.cells, middle, group);
      continue;
    }
    shape.nodes = withOwnRows(shape.nodes, sharp.borderNodes());
    shape.boundary = withOwnRows(shape.boundary, sharp.sample_node);
    correctGradients(sharp, shape.points, points.X, points.volume, X, shape.boundary, gradient_tolerance);
    if (!vertices.side_node.empty()) {
      p.side_node = std::move(vertices.side_node);
      p.vertex_group = std::move(vertices.group);
      p.volume_cells = std::move(vertices.cells);
    }
    for (const int c : points.cell) p.point_material.push_back(cell_material[c]);
    return shape;
  }
}

/// Masses of a place: one rule for each node on its own, so that nodes far from the tool keep theirs.
void addCommonMasses(const CommonToBody& common, const ShapeTable& shape, const std::vector<double>& volume,
                     const std::vector<Material>& materials, const NodePatches& patches, Preparation& p) {
  const auto rows = gershgorinRows(shape, volume, p.point_material, materials, p.mass.size());
  for (std::size_t i = 0; i < p.mass.size(); ++i) p.mass[i] = std::max(p.mass[i], rows[i] / common.row_limit);
  p.limit = criticalTimeStep(shape, volume, p.point_material, materials, p.mass, patches);
  if (p.limit.dt < common.critical) {
    ScaledMass scaled =
        scaleMass(shape, volume, p.point_material, materials, p.mass, patches, p.limit, common.critical);
    p.mass = std::move(scaled.mass);
    p.limit = scaled.limit;
  }
  p.limit.dt = std::min(p.limit.dt, common.critical);
}

/// Masses and the stable step, with the mass added that spares steps of a tick.
void addMasses(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells,
               const IntegrationPoints& points, const std::vector<int>& cell_material, const ShapeTable& shape,
               const CommonToBody* common, Preparation& p) {
  const std::vector<Material> materials = materialsOf(scene);
  std::vector<double> cell_density;
  cell_density.reserve(cell_material.size());
  for (const int m : cell_material) cell_density.push_back(materials[m].density);
  p.own_mass = p.mass = lumpedMass(X, cells.cells, cells.volume, cell_density);
  NodePatches patches;
  if (needsPatches(scene))
    patches = makeNodePatches(verticesOf(X, p.side_node), p.volume_cells.empty() ? cells.cells : p.volume_cells,
                              points.X, points.volume, points.cell, p.point_material, materials, ownBulk(scene));
  if (common != nullptr) {
    addCommonMasses(*common, shape, points.volume, materials, patches, p);
    return;
  }
  p.limit = criticalTimeStep(shape, points.volume, p.point_material, materials, p.mass, patches);
  if (!(scene.dynamics.mass_scaling > 0)) return;
  ScaledMass granted;
  longestCriticalStep(scene, p.limit.dt, [&](double wanted) {
    ScaledMass scaled = scaleMass(shape, points.volume, p.point_material, materials, p.mass, patches, p.limit, wanted);
    if (scaled.added > scene.dynamics.mass_scaling || scaled.limit.dt < wanted) return false;
    granted = std::move(scaled);
    return true;
  });
  if (granted.mass.empty()) return;
  p.mass = std::move(granted.mass);
  p.limit = granted.limit;
}

}  // namespace

std::vector<int> cellMaterials(const Scene& scene, const SurfaceTree& tree, const std::vector<Vec3>& X,
                               const BackgroundCells& cells) {
  return materialsAt(scene, centroids(X, cells.cells), tree);
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): its parts are moved from
Preparation prepare(const Scene& scene, const SurfaceTree& tree, Discretization discretization,
                    const Progress& progress, const CommonToBody* common, const RowMemory* memory) {
  // Shares of the time with 33,000 nodes and 190,000 points on two cores.
  const auto report = [&](const char* what, double fraction) {
    if (progress) progress(what, fraction);
  };
  Preparation p;
  auto& [cloud, cells] = discretization;
  p.surface_volume = cells.surface_volume;
  p.cell_volume = cells.total_volume;
  report("integration points", 0.43);
  auto radius = supportRadii(cloud.X, cells.cells, scene.discretization.support_factor);
  std::vector<int> cell_material = cellMaterials(scene, tree, cloud.X, cells);
  const ThinLayer layer = thinnestLayer(scene, tree, cloud.X, cells.cells, cell_material);
  p.thin_layer = layer.material;
  p.layer_error = layer.error;
  p.missed_shares = layer.missed;
  auto points =
      choosePoints(scene, cloud.X, cells, cell_material, radius, common != nullptr ? &common->pair_moment : nullptr);

  report("skin", 0.43);
  p.skin.surface = common != nullptr ? common->skin : refineForContact(scene, tree.surface());
  const SurfaceGaps own_gaps = common != nullptr ? SurfaceGaps{} : gapsOf(scene, p.skin.surface, tree);
  const SurfaceGaps& gaps = common != nullptr ? *common->gaps : own_gaps;

  p.essential = chooseImposed(scene, cloud, tree);
  if (!p.essential.nodes.empty()) checkHeld(scene, p.essential, cloud.X.size());
  const auto outer = boundaryFacets(cells.cells);
  std::vector<Vec3> facet_X;
  if (scene.discretization.boundary_method == DiscretizationSpec::BoundaryMethod::Ebciem)
    facet_X = essentialFacets(cloud, outer, p.essential);
  constexpr double gradient_tolerance = 1e-6;  // leaves 1e-7 of the displacement
  Approximation shape;
  if (hasSharpInterfaces(scene)) {
    report("shape functions", 0.44);
    shape = approximateSharply(scene, tree, cloud.X, cells, cell_material, points, p.skin.surface.vertices, facet_X,
                               radius, gaps, gradient_tolerance, memory, p);
  } else {
    const BoundaryPoints boundary = consistencyPoints(scene, cloud, outer, p.essential);
    report("shape functions", 0.44);
    shape = approximate(scene, cloud.X, std::move(radius), points.X, p.skin.surface.vertices, facet_X, boundary.X, gaps,
                        cells.cells, {}, nullptr, memory);
    report("consistent gradients", 0.58);
    if (scene.discretization.formulation.consistent_gradients)
      correctGradients(shape.points, points.X, points.volume, cloud.X, boundary, shape.boundary, gradient_tolerance);
    p.point_material = materialsAt(scene, points.X, tree);
  }

  report("mass and stable step", 0.81);
  for (std::size_t q = 0; q < points.other_cell.size(); ++q)  // between two cells of one material may lie another
    p.point_material[q] = cell_material[points.cell[q]];
  if (mixedMaterial(scene) != 0) {
    const std::vector<double> share = cellShares(scene, cloud.X, cells, cell_material);
    mixPoints(scene, share, cells, points, p.point_material);
    mixCells(scene, share, cell_material);
  }
  addMasses(scene, cloud.X, cells, points, cell_material, shape.points, common, p);

  p.X = std::move(cloud.X);
  p.support_radius = std::move(shape.radius);
  p.cells = std::move(cells.cells);
  p.point_X = std::move(points.X);
  p.point_volume = std::move(points.volume);
  p.point_cell = std::move(points.cell);
  p.point_other_cell = std::move(points.other_cell);
  p.point_shape = std::move(shape.points);
  p.node_shape = std::move(shape.nodes);
  p.end_node = {p.nodeCount()};
  p.end_point = {p.pointCount()};
  setRows(shape.skin, p.skin);
  p.essential.facet_phi = std::move(shape.facets);
  return p;
}

}  // namespace palpate

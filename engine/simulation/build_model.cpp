#include "simulation/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "discretization/boundary_points.h"
#include "discretization/consistent_gradients.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/lumped_mass.h"
#include "simulation/approximate.h"
#include "simulation/choose_time_step.h"
#include "simulation/discretize.h"
#include "simulation/imposed_nodes.h"
#include "simulation/scene_messages.h"
#include "simulation/scene_regions.h"

namespace palpate {

Model buildModel(const Scene& scene, const TriangleSurface& organ, const Progress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const auto tell = [&](const char* what, double fraction) {
    if (progress) progress(what, fraction);
  };
  Model model;
  model.scene = scene;

  tell("nodes and cells", 0.0);
  const SurfaceTree tree(organ);
  auto [cloud, cells] = discretize(scene, tree);
  const int nodes = static_cast<int>(cloud.X.size());
  model.surface_volume = cells.surface_volume;
  model.cell_volume = cells.total_volume;
  tell("integration points", 0.3);
  auto radius = supportRadii(cloud.X, cells.cells, scene.support_factor);
  const auto points = choosePoints(scene, cloud.X, cells, radius);

  tell("skin", 0.4);
  const TriangleSurface skin = refineForContact(scene, organ);

  tell("shape functions", 0.45);
  model.essential = chooseImposed(scene, cloud, tree);
  model.imposed.assign(nodes, 0);
  for (const auto& node : model.essential.nodes)
    for (int c = 0; c < 3; ++c)
      if (node.boundary[c] >= 0) model.imposed[node.node] |= static_cast<std::uint8_t>(1u << c);
  const auto outer = boundaryFacets(cells.cells);
  const bool integrated = scene.boundary_method == Scene::BoundaryMethod::Ebciem;
  std::vector<Vec3> facet_X;
  if (integrated) facet_X = essentialFacets(cloud, outer, model.essential);
  // Tractions that are integrated over facets can answer any stress; lumped ones only a sum over the nodes.
  const std::vector<std::uint8_t> lumped = integrated ? std::vector<std::uint8_t>(cloud.X.size(), 0) : model.imposed;
  BoundaryPoints boundary;
  if (scene.consistent_gradients) boundary = boundaryPoints(cloud.X, outer, lumped);
  auto shape = approximate(scene, cloud.X, std::move(radius), points.X, skin.vertices, facet_X, boundary.X);
  model.essential.facet_phi = std::move(shape.facets);
  model.essential.phi = rowsOf(shape.nodes, model.essential.nodes);
  model.support_radius = shape.radius;
  if (scene.consistent_gradients) {
    tell("consistent gradients", 0.7);
    // 1e-6 leaves 1e-7 of the displacement.
    correctGradients(shape.points, points.X, points.volume, cloud.X, boundary, shape.boundary, 1e-6);
  }

  tell("mass, boundaries, stable step", 0.8);
  for (const auto& spec : scene.materials) model.materials.push_back(toMaterial(spec));
  for (const auto& x : points.X) model.point_material.push_back(materialAt(scene, x, tree));
  std::vector<double> cell_density;
  for (const auto& cell : cells.cells) {
    const Vec3 centroid = (cloud.X[cell[0]] + cloud.X[cell[1]] + cloud.X[cell[2]] + cloud.X[cell[3]]) / 4;
    cell_density.push_back(model.materials[materialAt(scene, centroid, tree)].density);
  }
  model.mass = lumpedMass(cloud.X, cells.cells, cells.volume, cell_density);
  for (double m : model.mass) model.inverse_mass.push_back(static_cast<float>(1 / m));
  try {
    model.boundary = makeEssentialBoundary(model.essential, model.mass);
  } catch (const std::runtime_error& e) {
    throw InputError(scene.boundaries.front().place, e.what(), "make the regions smaller or discretization.seed another");
  }
  if (scene.node_patch_volume)
    model.patches = makeNodePatches(cloud.X, cells.cells, points.X, points.volume, points.cell, model.point_material, model.materials);
  const auto limit =
      criticalTimeStep(shape.points, points.volume, model.point_material, model.materials, model.mass, model.patches);
  chooseTimeStep(scene, limit, cloud.X, model);
  double wave_speed = 0;
  double softest = model.materials[0].shear_modulus;
  for (const auto& m : model.materials) {
    wave_speed = std::max(wave_speed, std::sqrt(m.waveModulus() / m.density));
    softest = std::min(softest, m.shear_modulus);
  }
  // Tissue does not move faster than sound in it; four times leaves room for whipping edges.
  model.max_increment = 4 * wave_speed * model.dt;

  tell("kernel layout", 0.9);
  model.kernel = makeKernelLayout(shape.points, points.X, points.volume, model.point_material, model.materials, nodes, model.patches);
  model.skin = buildSkinModel(skin, shape.skin, scene.tool.radius, 3 * softest);
  model.tool_start = {scene.tool_position, Quat::FromTwoVectors(-Vec3::UnitZ(), scene.tool_direction)};
  model.touch_travel = touchTravel(skin, scene.tool, model.tool_start);
  const Vec3 middle = model.tool_start.toWorld(Vec3(0, 0, scene.tool.radius));
  if (model.touch_travel < 0 || tree.inside(scene.tool_position) || tree.inside(middle))
    throw InputError(placeOf(scene, "tool.position"), "the tool starts inside the organ",
                     "move tool.position against tool.direction");
  if (!std::isfinite(model.touch_travel)) model.touch_travel = 0;  // never touches: depth counts from the start

  model.X = std::move(cloud.X);
  model.cells = std::move(cells.cells);
  model.point_X = points.X;
  model.point_volume = points.volume;
  model.point_shape = std::move(shape.points);
  model.point_cell = points.cell;
  model.node_shape = std::move(shape.nodes);
  model.node_shape.gradN.clear();
  model.skin_shape = std::move(shape.skin);
  tell("ready", 1.0);
  model.setup_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

State initialState(const Model& model) {
  State state;
  state.u.assign(model.X.size(), Float4{});
  state.du = state.u_low = state.u;
  state.tool_pose = model.tool_start;
  state.contact = makeContactState(model.skin, model.scene.tool);
  return state;
}

}  // namespace palpate

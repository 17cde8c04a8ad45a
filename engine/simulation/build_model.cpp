#include "simulation/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "discretization/surface/facet_rule.h"
#include "simulation/choose_time_step.h"
#include "simulation/imposed_nodes.h"
#include "simulation/scene_messages.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;

/// The essential boundary's nodes with what follows from them.
EssentialNodes essentialNodes(const Scene& scene, Preparation& p) {
  EssentialNodes essential;
  for (const auto& spec : scene.boundaries) essential.motions.push_back(motionOf(spec));
  essential.nodes = std::move(p.imposed_nodes);
  for (const auto& node : essential.nodes) essential.X.push_back(p.X[node.node]);
  essential.phi = rowsOf(p.node_shape, essential.nodes);
  essential.facets = std::move(p.facets);
  essential.facet_weight = std::move(p.facet_weight);
  essential.facet_phi = std::move(p.facet_phi);
  if (scene.boundary_method == Scene::BoundaryMethod::Ebciem) essential.facet_points = FacetRule::size;
  return essential;
}

void placeTool(const Scene& scene, const SurfaceTree& tree, Model& model) {
  model.tool_start = {scene.tool_position, Quat::FromTwoVectors(-Vec3::UnitZ(), scene.tool_direction)};
  model.first_contact_travel = firstContactTravel(model.skin.surface, scene.tool, model.tool_start);
  const Vec3 middle = model.tool_start.toWorld(Vec3(0, 0, scene.tool.radius));
  if (model.first_contact_travel < 0 || tree.inside(scene.tool_position) || tree.inside(middle))
    throw InputError(placeOf(scene, "tool.position"), "the tool starts inside the organ",
                     "move tool.position against tool.direction");
  if (!std::isfinite(model.first_contact_travel))
    model.first_contact_travel = 0;  // never touches: depth counts from the start
}

}  // namespace

Model buildModel(const Scene& scene, const TriangleSurface& organ, const Progress& progress) {
  const auto start = Clock::now();
  const SurfaceTree tree(organ);
  Model model = finishModel(scene, tree, prepare(scene, tree, progress), progress);
  model.setup_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return model;
}

Model finishModel(const Scene& scene, const SurfaceTree& tree, Preparation p, const Progress& progress) {
  const auto report = [&](const char* what, double fraction) {
    if (progress) progress(what, fraction);
  };
  const auto start = Clock::now();
  report("boundaries", 0.95);
  Model model;
  model.scene = scene;
  model.materials = materialsOf(scene);
  const int nodes = static_cast<int>(p.X.size());
  model.imposed = imposedComponents(p.imposed_nodes, p.X.size());
  model.essential = essentialNodes(scene, p);
  for (double m : p.mass) model.inverse_mass.push_back(static_cast<float>(1 / m));
  try {
    model.boundary = makeEssentialBoundary(model.essential, p.mass);
  } catch (const std::runtime_error& e) {
    throw InputError(scene.boundaries.front().place, e.what(),
                     "make the regions smaller or discretization.seed another");
  }
  if (scene.node_patch_volume)
    model.patches =
        makeNodePatches(p.X, p.cells, p.point_X, p.point_volume, p.point_cell, p.point_material, model.materials);
  chooseTimeStep(scene, p.limit, p.X, model);
  double wave_speed = 0;
  double softest = model.materials[0].shear_modulus;
  for (const auto& m : model.materials) {
    wave_speed = std::max(wave_speed, std::sqrt(m.waveModulus() / m.density));
    softest = std::min(softest, m.shear_modulus);
  }
  // Tissue does not move faster than sound in it; four times leaves room for whipping edges.
  model.max_increment = 4 * wave_speed * model.dt;
  double shear = 0;  // J, shear moduli times volumes
  for (std::size_t q = 0; q < p.point_volume.size(); ++q)
    shear += p.point_volume[q] * model.materials[p.point_material[q]].shear_modulus;
  model.rest_energy =
      1e-5 * shear;  // of strains of about 0.3 %, far above float's rounding (of the stiffest part, too)
  model.skin = buildSkinModel(p.skin, p.skin_shape, scene.tool.radius, 3 * softest);
  placeTool(scene, tree, model);

  report("kernel layout", 0.96);
  model.kernel = makeKernelLayout(p.point_shape, p.point_X, p.point_volume, p.point_material, model.materials, nodes,
                                  model.patches, scene.gradient_precision, p.X);

  model.X = std::move(p.X);
  model.support_radius = std::move(p.support_radius);
  model.mass = std::move(p.mass);
  model.cells = std::move(p.cells);
  model.surface_volume = p.surface_volume;
  model.cell_volume = p.cell_volume;
  model.added_mass = p.added_mass;
  model.point_X = std::move(p.point_X);
  model.point_volume = std::move(p.point_volume);
  model.point_material = std::move(p.point_material);
  model.point_cell = std::move(p.point_cell);
  model.point_other_cell = std::move(p.point_other_cell);
  model.point_shape = std::move(p.point_shape);
  model.node_shape = std::move(p.node_shape);
  model.skin_shape = std::move(p.skin_shape);
  report("ready", 1.0);
  model.setup_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return model;
}

State initialState(const Model& model) {
  State state;
  state.u.assign(model.X.size(), Float4{});
  state.du = state.u_low = state.u;
  state.tool_pose = model.tool_start;
  state.contact = makeContactState(model.skin, model.scene.tool);
  state.live = loadedParameters(model);
  return state;
}

}  // namespace palpate

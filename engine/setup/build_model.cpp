#include "setup/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "discretization/surface/facet_rule.h"
#include "discretization/surface/surface_bodies.h"
#include "scene/scene_messages.h"
#include "scene/scene_rigid.h"
#include "setup/body_points.h"
#include "setup/choose_time_step.h"
#include "setup/discretize_parts.h"
#include "setup/finish.h"
#include "setup/imposed_nodes.h"
#include "setup/join_bodies.h"
#include "setup/make_surface_loads.h"
#include "setup/make_tools.h"
#include "setup/mixtures.h"
#include "setup/prepare.h"

namespace palpate {
namespace {

using Clock = std::chrono::steady_clock;

/// Where an imposed point that is no node stands, m.
const Vec3& imposedPoint(const Scene& scene, const ImposedNode& point) {
  return scene.boundaries[*std::max_element(point.boundary.begin(), point.boundary.end())].region.point;
}

/// Whether the cells take pressure over from the patches: not where a face is turned, or moved while it is bonded,
/// which curves the flow, of which cells see chords; but in a body that is held all around and pressed without a turn.
/// Not under surface loads, which are in equilibrium with points: what cells hold acts on other nodes of a face, and
/// the loaded face of a confined block (nu 0.48, 2 shear moduli) is then off by half of its displacement, not 1e-5.
bool keepsCellVolume(const Model& model) {
  if (!model.scene.discretization.formulation.cell_volume || model.patches.empty() || !model.scene.loads.empty())
    return false;
  bool turned = false, bonded_moves = false;
  for (const BoundarySpec& boundary : model.scene.boundaries) {
    const auto* held = boundary.component;
    turned |= boundary.angle != 0 || boundary.points;
    bonded_moves |= boundary.duration > 0 && held[0] + held[1] + held[2] > 1;
  }
  return !turned && (!bonded_moves || isConfined(model.cellVolume()));
}

/// Of each body the gaps in its own skin.
std::vector<std::shared_ptr<const SurfaceGaps>> gapsOfBodies(const Scene& scene, const SurfaceTree& tree,
                                                             const TriangleSurface& skin, int count) {
  if (count == 1) return {std::make_shared<const SurfaceGaps>(gapsOf(scene, skin, tree))};
  std::vector<std::shared_ptr<const SurfaceGaps>> gaps;
  const std::vector<TriangleSurface> skins = separated(skin, bodiesOf(skin)),
                                     bodies = separated(tree.surface(), bodiesOf(tree.surface()));
  for (std::size_t k = 0; k < bodies.size(); ++k)
    gaps.push_back(std::make_shared<const SurfaceGaps>(gapsOf(scene, skins[k], SurfaceTree(bodies[k]))));
  return gaps;
}

/// What follows from the imposed nodes and the scene.
void completeEssential(const Scene& scene, Model& model) {
  EssentialNodes& essential = model.essential;
  essential.motions.clear();
  for (const auto& spec : scene.boundaries) essential.motions.push_back(motionOf(spec));
  essential.X.clear();
  std::vector<Vec3> points;  // between the nodes
  for (const auto& node : essential.nodes) {
    if (node.node < 0) points.push_back(imposedPoint(scene, node));
    essential.X.push_back(node.node < 0 ? points.back() : model.X[node.node]);
  }
  essential.phi = rowsOf(model.node_shape, essential.nodes, points.empty() ? ShapeTable{} : shapeAt(model, points));
  essential.facet_points = essential.facets.empty() ? 0 : FacetRule::size;
  model.imposed = imposedComponents(essential.nodes, model.X.size());
  try {
    model.boundary = makeEssentialBoundary(essential, model.mass);
  } catch (const std::runtime_error& e) {
    throw InputError(scene.boundaries.front().place, e.what(),
                     "make the regions smaller or discretization.seed another");
  }
}

/// The weight at the nodes, f_i = sum_q V_q rho_q N_i(X_q) g: of the tissue itself, not of mass that was added for the
/// sake of the step.
void addWeight(Model& model) {
  const Vec3& g = model.scene.dynamics.gravity;
  if (g.isZero(0)) return;
  std::vector<Vec3> weight(model.X.size(), Vec3::Zero());
  const ShapeTable& shape = model.point_shape;
  for (int q = 0; q < model.pointCount(); ++q) {
    const double mass = model.point_volume[q] * model.materials[model.point_material[q]].density;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) weight[shape.node[e]] += mass * shape.N[e] * g;
  }
  for (const Vec3& f : weight) model.weight.push_back(toReal4<double>(f));
}

/// What tells rounding and blow-ups from motion.
void setBounds(Model& model) {
  double wave_speed = 0, shear = 0;  // m/s; J, shear moduli times volumes
  for (const auto& m : model.materials) wave_speed = std::max(wave_speed, std::sqrt(m.waveModulus() / m.density));
  for (std::size_t q = 0; q < model.point_volume.size(); ++q)
    shear += model.point_volume[q] * model.materials[model.point_material[q]].shear_modulus;
  // Tissue does not move faster than sound in it, or than a tool that is faster; four times and twice that leave room
  // for whipping edges. A node that goes all the way to the next in one step is lost in any case. Not of the finest
  // spacing, nor half of the way: skin that slips off a tool whips back at half the speed of sound, whatever the cloud.
  model.max_increment = std::min(std::max(4 * wave_speed, 2 * largestToolSpeed(model.scene)) * model.dt,
                                 model.scene.discretization.spacing);
  // Of strains of about 0.3 %, far above float's rounding (of the stiffest part, too).
  model.rest_energy = 1e-5 * shear;
}

/// N, where the tool yields by default: a mean pressure of forty shear moduli on its cross-section. Up to that pressure
/// the volume of confined tissue is exact (tests hold it to 40), and a hand that presses a ball of 20 mm into liver
/// meets a tenth of it at a depth of its radius.
double maxToolForce(double asked, double radius, const std::vector<Material>& materials) {
  constexpr double pressure = 40;  // shear moduli
  if (asked > 0) return asked;
  double stiffest = 0;  // Pa
  for (const Material& m : materials) stiffest = std::max(stiffest, m.shear_modulus);
  return pressure * stiffest * std::numbers::pi * radius * radius;
}

/// N, at which jaws close no further. Not said: what holds without crushing, about as much as a ball meets that is
/// pressed into a half-space by its radius (Hertz: 16/3 shear moduli times radius^2).
double gripForce(double asked, double radius, const Model& model) {
  // Mean shear moduli. The strip of strip_grasp, held and lifted: 2 leaves min J 0.59; 3 leaves 0.50, and the force is
  // doubted; where nothing stops the jaws, 0.11.
  constexpr double pressure = 2;
  if (asked > 0) return asked;
  double volume = 0, stiffness = 0;  // m^3, Pa m^3
  for (std::size_t q = 0; q < model.point_volume.size(); ++q) {
    volume += model.point_volume[q];
    stiffness +=
        model.point_volume[q] * model.materials[static_cast<std::size_t>(model.point_material[q])].shear_modulus;
  }
  return pressure * stiffness / volume * std::numbers::pi * radius * radius;
}

/// Which organ each body is of, and each node.
void addBodies(const Scene& scene, const SurfaceTree& tree, const CommonToPlaces* common, Model& model) {
  model.bodies = common != nullptr ? common->bodies
                                   : makeSkinBodies(model.skin, scene.discretization.spacing, spacingField(scene));
  SkinBodies& bodies = model.bodies;
  addRows(model.skin, bodies);
  if (bodies.count > max_skin_bodies)
    throw InputError(scene.place,
                     "the surface has " + number(bodies.count) + " separate bodies, and at most " +
                         number(max_skin_bodies) + " can touch one another",
                     "leave small parts out (mtled import does)");
  const std::vector<int>& organ = tree.surface().organ;
  if (!bodies.several() || organ.empty()) return;
  const std::vector<OrganSpec>& organs = scene.organs;
  const SurfaceBodies of_faces = bodiesOf(tree.surface());  // numbered as those of the skin, which is made of them
  for (std::size_t t = 0; t < organ.size(); ++t) bodies.organ[static_cast<std::size_t>(of_faces.of_face[t])] = organ[t];
  for (std::size_t b = 0; b < bodies.organ.size(); ++b)
    bodies.friction[b] = static_cast<float>(organs[static_cast<std::size_t>(bodies.organ[b])].friction);
  // Nodes that carry skin are its body's, and those that share a cell with one.
  std::vector<int>& of_node = model.node_organ;
  of_node.assign(model.X.size(), -1);
  for (int v = 0; v < model.skin.vertexCount(); ++v)
    for (int e = model.skin.begin[v]; e < model.skin.begin[v + 1]; ++e)
      of_node[static_cast<std::size_t>(model.skin.node[e])] =
          bodies.organ[static_cast<std::size_t>(bodies.body[static_cast<std::size_t>(v)])];
  for (bool found = true; found;) {
    found = false;
    for (const auto& cell : model.cells) {
      int of_cell = -1;
      for (const int i : cell) of_cell = std::max(of_cell, of_node[static_cast<std::size_t>(i)]);
      for (const int i : cell) {
        found |= of_node[static_cast<std::size_t>(i)] < of_cell;
        of_node[static_cast<std::size_t>(i)] = std::max(of_node[static_cast<std::size_t>(i)], of_cell);
      }
    }
  }
}

/// The contact layer, as stiff as the tissue beneath each vertex that the integration points see: elsewhere it may be
/// softer.
/// @param spacing  m, of the nodes where tools go
void addLayer(double spacing, Model& model) {
  SkinModel& skin = model.skin;
  skin.layer_depth = layerDepth(smallestToolRadius(model.scene), spacing);
  std::vector<float> of_material;
  for (const Material& m : model.materials)
    of_material.push_back(
        static_cast<float>(layerModulus(m.bulk_modulus, m.shear_modulus + m.fibre_modulus / 3) / skin.layer_depth));
  skin.layer.assign(skin.area.size(), of_material[0]);
  if (of_material.size() == 1) return;
  const std::vector<int> below = nearestPoints(model, skin.surface.vertices, model.bodies.body);
  for (std::size_t v = 0; v < below.size(); ++v) skin.layer[v] = of_material[model.point_material[below[v]]];
}

/// Skin vertices that nodes move which displacements are imposed on (vertex_count); empty: there are none.
std::vector<std::uint8_t> besideHeld(const SkinModel& skin, const EssentialBoundary& boundary) {
  std::vector<std::uint8_t> held, beside;
  for (const auto& set : boundary.sets)
    for (const int i : set.touched) {
      held.resize(std::max(held.size(), static_cast<std::size_t>(i) + 1));
      held[i] = 1;
    }
  if (held.empty()) return beside;
  beside.resize(static_cast<std::size_t>(skin.vertexCount()));
  for (int v = 0; v < skin.vertexCount(); ++v)
    for (int e = skin.begin[v]; e < skin.begin[v + 1]; ++e)
      if (static_cast<std::size_t>(skin.node[e]) < held.size()) beside[v] |= held[skin.node[e]];
  return beside;
}

/// The skin as the contact reads it, and the tools before it.
void addSkinAndTool(const Scene& scene, const SurfaceTree& tree, const CommonToPlaces* common, Model& model) {
  SkinModel skin = common != nullptr ? common->skin : skinOf(model.skin.surface);
  skin.begin = std::move(model.skin.begin);
  skin.node = std::move(model.skin.node);
  skin.N = std::move(model.skin.N);
  model.skin = std::move(skin);
  addBodies(scene, tree, common, model);
  SpacingField spacing = spacingField(scene);
  if (common != nullptr) {  // the same points at all places
    spacing.spacing = common->finest_spacing;
    spacing.refinements.clear();
  }
  addLayer(common != nullptr ? common->finest_spacing : scene.discretization.spacing, model);
  model.rigid = rigidBodiesOf(scene, tree, model.skin, model.bodies.body, spacing);
  model.tools = common != nullptr ? common->tools : makeToolSet(scene, tree, model.skin.surface);
  for (ToolSetUp& tool : model.tools.tool) {
    tool.max_force = maxToolForce(tool.max_force, tool.shape.radius, model.materials);
    if (tool.jaws) tool.grip_force = gripForce(tool.grip_force, tool.shape.radius, model);
  }
}

}  // namespace

SkinModel skinOf(const TriangleSurface& surface) {
  SkinModel skin = buildSkinModel(surface, {});
  skin.topology = std::make_shared<const SkinTopology>(makeSkinTopology(surface));
  return skin;
}

Model finish(const Scene& scene, const SurfaceTree& tree, Preparation preparation, const Progress& report,
             const CommonToPlaces* common) {
  report("boundaries", 0.95);
  Model model;
  static_cast<Preparation&>(model) = std::move(preparation);
  model.scene = scene;
  model.materials = materialsOf(scene);
  model.point_groups = makePointGroups(model, mixtureBases(scene));
  for (const double m : model.mass) model.inverse_mass.push_back(static_cast<float>(1 / m));
  if (model.mass != model.own_mass)
    for (std::size_t i = 0; i < model.mass.size(); ++i)
      model.own_share.push_back(static_cast<float>(model.own_mass[i] / model.mass[i]));
  model.gaps = common != nullptr ? common->gaps : gapsOfBodies(scene, tree, model.skin.surface, model.bodyCount());
  completeEssential(scene, model);
  if (needsPatches(scene))
    model.patches = makeNodePatches(
        verticesOf(model.X, model.side_node), model.volume_cells.empty() ? model.cells : model.volume_cells,
        model.point_X, model.point_volume, model.point_cell, model.point_material, model.materials, ownBulk(scene));
  chooseTimeStep(scene, model.limit, model.X, model);
  addWeight(model);
  setBounds(model);
  addSkinAndTool(scene, tree, common, model);
  model.held = heldTissue(model);
  model.beside_held = besideHeld(model.skin, model.boundary);
  model.surface_loads = makeSurfaceLoads(model, tree);

  report("kernel layout", 0.96);
  model.kernel = makeKernelLayout(model.point_shape, model.point_X, model.point_volume, model.point_material,
                                  model.materials, model.nodeCount(), model.patches, scene.dynamics.gradient_precision,
                                  model.X, mixtureBases(scene));
  if (keepsCellVolume(model)) model.kernel.cell_volume = makeCellVolume<float>(model.cellVolume());
  std::vector<std::array<int, 4>> vertices;  // of each point's cell
  for (const int c : model.point_cell) vertices.push_back(model.cells[c]);
  model.stiffness_means = makeStiffnessMeans(model.kernel, model.point_shape, vertices, model.point_volume,
                                             model.point_material, model.materials, model.boundary);
  report("ready", 1.0);
  return model;
}

namespace {

/// Discretizes and prepares one body.
class BodyBuilder {
 public:
  BodyBuilder(const Scene& scene, TriangleSurface surface)
      : scene_(sceneOf(scene, surface)), tree_(std::move(surface)) {}

  void discretize(const BuildOptions& options, const std::function<void(double)>& progress) {
    discretization_ = palpate::discretize(scene_, tree_, progress);
    if (options.disturb) options.disturb(discretization_, tree_);
  }
  bool has(std::size_t boundary) const {
    return choosesNode(scene_.boundaries[boundary], discretization_.cloud, tree_);
  }
  Preparation prepare(const Progress& report) {
    return palpate::prepare(scene_, tree_, std::move(discretization_), report);
  }

 private:
  Scene scene_;
  SurfaceTree tree_;
  Discretization discretization_;
};

/// The long first half of buildModel: of each body on its own.
Preparation prepareBodies(const Scene& scene, const TriangleSurface& organ, const BuildOptions& options,
                          const Progress& report) {
  constexpr double cloud_share = 0.43;
  std::vector<BodyBuilder> bodies;
  for (TriangleSurface& surface : separated(organ, bodiesOf(organ))) bodies.emplace_back(scene, std::move(surface));
  const double share = 1.0 / static_cast<double>(bodies.size());
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const auto progress = [&](double part) {
      report("nodes and cells", cloud_share * share * (static_cast<double>(k) + part));
    };
    progress(0);
    bodies[k].discretize(options, progress);
  }
  checkBoundaries(scene, bodies.size(), [&](std::size_t k, std::size_t b) { return bodies[k].has(b); });
  if (bodies.size() == 1) return bodies.front().prepare(report);
  std::vector<Preparation> prepared;
  for (std::size_t k = 0; k < bodies.size(); ++k)
    prepared.push_back(bodies[k].prepare([&](const std::string& what, double fraction) {
      report(what, cloud_share + (1 - cloud_share) * share * static_cast<double>(k) + share * (fraction - cloud_share));
    }));
  return joinBodies(std::move(prepared));
}

}  // namespace

Model buildModel(const Scene& scene, const TriangleSurface& organ, const BuildOptions& options) {
  const auto start = Clock::now();
  const Progress report = [&](const std::string& what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };
  std::optional<Preparation> preparation;
  if (options.find) preparation = options.find();
  if (!preparation) {
    preparation = prepareBodies(scene, organ, options, report);
    if (options.keep) {
      report("keeping it for the next start", 0.94);
      options.keep(*preparation);
    }
  }
  Model model = finish(scene, SurfaceTree(organ), std::move(*preparation), report);
  model.setup_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return model;
}

State initialState(const Model& model) {
  State state;
  state.u.assign(model.X.size(), Float4{});
  state.du = state.u_low = state.u;
  state.tool.clear(), state.contact.clear();
  for (const ToolSetUp& tool : model.tools.tool) state.tool.push_back(tool.start);
  for (const ToolBody& body : model.tools.body) state.contact.push_back(makeContactState(model.skin, body.shape));
  state.skins = makeSkinContactState(model.bodies);
  state.rigid = makeRigidState(model.rigid, model.nodeCount());
  state.live = loadedParameters(model);
  state.local_mass.factor.assign(model.X.size(), 1.0F);
  state.relaxation = makeRelaxationHistory<float>(model.kernel.batch_material.size(), model.materials);
  return state;
}

}  // namespace palpate

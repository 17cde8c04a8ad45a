#include "simulation/build_model.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "approximation/shape_functions.h"
#include "discretization/adaptive_quadrature.h"
#include "discretization/background_cells.h"
#include "discretization/consistent_gradients.h"
#include "discretization/facet_rule.h"
#include "discretization/gradient_energy.h"
#include "discretization/integration_points.h"
#include "discretization/node_cloud.h"
#include "discretization/node_order.h"
#include "discretization/refine_surface.h"
#include "discretization/surface_geometry.h"
#include "discretization/surface_tree.h"
#include "discretization/volume_fit.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/lumped_mass.h"

namespace palpate {
namespace {

std::string number(double a) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", a);
  return text;
}
std::string coordinates(const Vec3& x) {
  return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ") m";
}

Place placeOf(const Scene& scene, const std::string& key) {
  const auto it = scene.places.find(key);
  return it == scene.places.end() ? scene.place : it->second;
}

Material toMaterial(const MaterialSpec& spec) {
  Material material = spec.kind == MaterialSpec::Kind::NeoHookean
                          ? Material::neoHookean(spec.young, spec.poisson, spec.density)
                          : Material::ogden(spec.ogden_mu.data(), spec.ogden_alpha.data(),
                                            static_cast<int>(spec.ogden_mu.size()), spec.ogden_D1, spec.density);
  material.barrier_strength = spec.barrier_strength;
  material.barrier_J0 = spec.barrier_J0;
  return material;
}

bool contains(const Region& region, const Vec3& x, const SurfaceTree& organ) {
  constexpr double tolerance = 1e-9;  // m; nodes that were put on a plane are on it
  if (region.kind != Region::Kind::Shell) return region.contains(x, tolerance);
  return region.contains(x, tolerance, organ.closest(x, region.distance + 2 * tolerance).distance);
}

/// Of several materials, the last whose region holds x.
int materialAt(const Scene& scene, const Vec3& x, const SurfaceTree& organ) {
  for (int m = static_cast<int>(scene.materials.size()) - 1; m > 0; --m)
    if (scene.materials[m].everywhere || contains(scene.materials[m].region, x, organ)) return m;
  return 0;
}

SpacingField spacingField(const Scene& scene) {
  SpacingField spacing;
  spacing.spacing = scene.spacing;
  spacing.place = placeOf(scene, "discretization.spacing");
  for (const auto& r : scene.refine) spacing.refinements.push_back({r.centre, r.radius, r.spacing, r.blend, r.place});
  return spacing;
}

/// The skin's vertices sample the contact pressure: 0.35 tool radii is what contact/skin.h asks for, and
/// where the nodes are denser than the tool is wide, a third of their spacing keeps up with them.
TriangleSurface refineForContact(const Scene& scene, const TriangleSurface& organ) {
  const SpacingField spacing = spacingField(scene);
  const double by_tool = 0.35 * scene.tool.radius;
  return refineSurface(organ, [&](const Vec3& x) {
    const double h = spacing.at(x);
    return h < scene.spacing ? std::min(by_tool, h / 3) : by_tool;
  });
}

/// Where the mantle of an imposed cylindrical region meets the organ's surface, so that the region ends at nodes: a
/// punch whose rim falls between nodes would be too small by half their distance. No curve where the rim leaves the organ.
std::vector<FeatureEdges::Chain> rimsOf(const Scene& scene, const SurfaceTree& organ) {
  std::vector<FeatureEdges::Chain> rims;
  for (const auto& boundary : scene.boundaries) {
    const Region& region = boundary.region;
    if (region.kind != Region::Kind::Cylinder) continue;
    const int count = std::max(32, static_cast<int>(std::ceil(8 * 2 * M_PI * region.radius / scene.spacing)));
    const Vec3 e1 = region.normal.unitOrthogonal(), e2 = region.normal.cross(e1);
    FeatureEdges::Chain chain;
    chain.closed = true;
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * M_PI * k / count;
      // A hair inside, so that the nodes are in the region.
      const Vec3 arm = (region.radius - 1e-10) * (std::cos(angle) * e1 + std::sin(angle) * e2);
      const double past = 1e-3 * region.radius;  // beyond both ends
      const auto hit = organ.firstHit(region.point + arm + (region.height + past) * region.normal, -region.normal, region.height + 2 * past);
      if (!hit) break;
      chain.points.push_back(hit->point);
    }
    if (static_cast<int>(chain.points.size()) < count) continue;
    chain.points.push_back(chain.points.front());
    rims.push_back(std::move(chain));
  }
  return rims;
}

struct Discretization {
  NodeCloud cloud;
  BackgroundCells cells;
};

/// Nodes and cells; nodes along a Hilbert curve.
Discretization discretize(const Scene& scene, const SurfaceTree& organ) {
  // What the set-up can hold: about 0.1 MB a node. A typing error in the spacing should not fill the memory.
  constexpr double most_nodes = 60000;
  const double estimate = signedVolume(organ.surface()) / (0.7 * scene.spacing * scene.spacing * scene.spacing);
  if (estimate > most_nodes)
    throw InputError(placeOf(scene, "discretization.spacing"),
                     "a spacing of " + number(scene.spacing) + " m makes about " + number(estimate) + " nodes, more than " +
                         number(most_nodes),
                     "raise it, and refine where the tool works");

  Discretization d;
  d.cloud = makeNodeCloud(organ, spacingField(scene), scene.seed, rimsOf(scene, organ));
  d.cells = makeBackgroundCells(d.cloud, organ);
  fitToVolume(d.cloud, d.cells, organ);

  const auto order = hilbertOrder(d.cloud.X);
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  d.cloud.X = reordered(d.cloud.X, order);
  d.cloud.on_surface = reordered(d.cloud.on_surface, order);
  for (auto& cell : d.cells.cells)
    for (int& node : cell) node = place[node];
  return d;
}

/// R_j = factor * (mean length of the cell edges at node j).
std::vector<double> supportRadii(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells, double factor) {
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

constexpr int max_enlargements = 8;  // by 1.15 each: a support radius grows at most threefold

/// The cells' integration points, adaptive where the scene asks for it. Supports on which the adaptive
/// quadrature can't judge are enlarged in `radius`.
IntegrationPoints choosePoints(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells, std::vector<double>& radius) {
  const QuadratureSpec& spec = scene.quadrature;
  if (spec.accuracy == 0) return makeIntegrationPoints(X, cells.cells, cells.volume, spec.points_per_cell);
  AdaptiveOptions options;
  options.accuracy = spec.accuracy;
  options.points_per_cell = spec.points_per_cell;
  options.division = spec.division;
  options.max_depth = spec.max_depth;
  for (int attempt = 0;; ++attempt) {
    const Neighbours neighbours(X, radius);
    try {
      auto adaptive = makeAdaptivePoints(X, cells.cells, cells.volume, options,
                                         GradientEnergy(X, radius, neighbours, {scene.basis_degree, scene.mu}));
      if (adaptive.not_finite.empty() || attempt == max_enlargements) return std::move(adaptive.points);
      std::vector<InadmissibleSupport> failed;
      for (int k = 0; k < static_cast<int>(adaptive.not_finite.size()); ++k) {
        failed.emplace_back();
        failed.back().row = k;
      }
      std::vector<double> enlarged = radius;
      enlargeSupports(adaptive.not_finite, failed, neighbours, enlarged);
      radius = std::move(enlarged);
    } catch (const InputError& error) {
      throw InputError(placeOf(scene, "discretization.quadrature_accuracy"), error.what(), "");
    }
  }
}

BoundaryMotion motionOf(const BoundarySpec& spec) {
  return {spec.translation, spec.axis_point, spec.axis, spec.angle, spec.duration, spec.curve};
}

/// True where both impose the same displacement on what stands at X, at all times.
bool agree(const BoundarySpec& a, const BoundarySpec& b, const Vec3& X, int component) {
  const BoundaryMotion p = motionOf(a), q = motionOf(b);
  if (!p.moves() && !q.moves()) return true;
  // Curves are polynomials or linear between their tables' times: equal at these and at a few times more, they are equal.
  constexpr int samples = 16;
  const double end = std::max({p.duration, q.duration, p.curve.time.empty() ? 0 : p.curve.time.back(),
                               q.curve.time.empty() ? 0 : q.curve.time.back()});
  std::vector<double> times;
  for (int k = 1; k <= samples; ++k) times.push_back(end * k / samples);
  for (const auto* curve : {&p.curve, &q.curve})
    for (std::size_t k = 1; k < curve->time.size(); ++k) {
      times.push_back(curve->time[k]);
      times.push_back((curve->time[k - 1] + curve->time[k]) / 2);
    }
  return std::all_of(times.begin(), times.end(),
                     [&](double t) { return std::abs((p.at(X, t) - q.at(X, t))[component]) <= 1e-12; });
}

/// Which nodes are imposed, and how. Throws where a region is empty or two motions contradict.
EssentialNodes chooseImposed(const Scene& scene, const NodeCloud& cloud, const SurfaceTree& organ) {
  EssentialNodes essential;
  std::vector<int> slot(cloud.X.size(), -1);
  for (int b = 0; b < static_cast<int>(scene.boundaries.size()); ++b) {
    const auto& spec = scene.boundaries[b];
    essential.motions.push_back(motionOf(spec));
    int found = 0;
    for (int i = 0; i < static_cast<int>(cloud.X.size()); ++i) {
      if (spec.surface_only && !cloud.on_surface[i]) continue;
      if (!contains(spec.region, cloud.X[i], organ)) continue;
      ++found;
      if (slot[i] < 0) {
        slot[i] = static_cast<int>(essential.nodes.size());
        essential.nodes.push_back({i, {-1, -1, -1}});
        essential.X.push_back(cloud.X[i]);
      }
      auto& owner = essential.nodes[slot[i]].boundary;
      for (int c = 0; c < 3; ++c) {
        if (!spec.component[c]) continue;
        if (owner[c] < 0) owner[c] = b;  // of boundaries that agree the first has the reaction
        if (!agree(spec, scene.boundaries[owner[c]], cloud.X[i], c))
          throw InputError(spec.place,
                           "the node at " + coordinates(cloud.X[i]) + " is also imposed, with another motion, at " +
                               scene.boundaries[owner[c]].place.text(),
                           "make the regions disjoint, or impose other components");
      }
    }
    if (found == 0)
      throw InputError(spec.place, "no node lies in this region", "move or enlarge it (node spacing is " + number(scene.spacing) + " m)");
  }
  return essential;
}

/// The facets that EBCIEM integrates over, and the places of their quadrature points.
std::vector<Vec3> essentialFacets(const NodeCloud& cloud, const std::vector<std::array<int, 3>>& outer, EssentialNodes& essential) {
  std::vector<bool> imposed(cloud.X.size(), false);
  for (const auto& node : essential.nodes) imposed[node.node] = true;
  std::vector<Vec3> points;
  essential.facet_points = FacetRule::size;
  for (const auto& f : outer) {
    if (!imposed[f[0]] || !imposed[f[1]] || !imposed[f[2]]) continue;
    essential.facets.push_back(f);
    const double area = (cloud.X[f[1]] - cloud.X[f[0]]).cross(cloud.X[f[2]] - cloud.X[f[0]]).norm() / 2;
    for (int k = 0; k < FacetRule::size; ++k) {
      points.push_back(FacetRule::point(k, cloud.X[f[0]], cloud.X[f[1]], cloud.X[f[2]]));
      essential.facet_weight.push_back(area * FacetRule::weight(k) * FacetRule::corners(k));
    }
  }
  return points;
}

/// Shape functions at integration points, skin vertices, nodes and samples of the boundary, over supports that
/// are enlarged where they must be.
struct Approximation {
  std::vector<double> radius;
  ShapeTable points, skin, nodes, facets, boundary;
};

Approximation approximate(const Scene& scene, const std::vector<Vec3>& X, std::vector<double> radius,
                          const std::vector<Vec3>& point_X, const std::vector<Vec3>& skin_X,
                          const std::vector<Vec3>& facet_X, const std::vector<Vec3>& boundary_X) {
  const MmlsOptions options{scene.basis_degree, scene.mu};
  Approximation a;
  for (int attempt = 0;; ++attempt) {
    const Neighbours neighbours(X, radius);
    const std::pair<const std::vector<Vec3>*, ShapeTable*> parts[] = {
        {&point_X, &a.points}, {&skin_X, &a.skin}, {&X, &a.nodes}, {&facet_X, &a.facets}, {&boundary_X, &a.boundary}};
    bool admissible = true;
    std::vector<double> enlarged = radius;
    for (const auto& [at, table] : parts) {
      std::vector<InadmissibleSupport> failed;
      *table = shapeFunctions(*at, X, radius, neighbours, options, failed);
      if (failed.empty()) continue;
      admissible = false;
      if (attempt == max_enlargements)
        throw InputError(placeOf(scene, "discretization.support_factor"),
                         "the support of the point at " + coordinates((*at)[failed.front().row]) + " is inadmissible (" +
                             std::to_string(failed.front().support_count) + " nodes)",
                         "raise discretization.support_factor or lower discretization.spacing");
      std::vector<double> mine = radius;
      enlargeSupports(*at, failed, neighbours, mine);
      for (std::size_t i = 0; i < mine.size(); ++i) enlarged[i] = std::max(enlarged[i], mine[i]);
    }
    if (admissible) break;
    radius = enlarged;
  }
  a.radius = radius;
  return a;
}

/// The rows of a shape table at some of its points.
ShapeTable rowsOf(const ShapeTable& table, const std::vector<ImposedNode>& nodes) {
  ShapeTable rows;
  rows.begin.push_back(0);
  for (const auto& node : nodes) {
    const int begin = table.begin[node.node], end = table.begin[node.node + 1];
    rows.node.insert(rows.node.end(), table.node.begin() + begin, table.node.begin() + end);
    rows.N.insert(rows.N.end(), table.N.begin() + begin, table.N.begin() + end);
    rows.begin.push_back(static_cast<int>(rows.node.size()));
  }
  return rows;
}

void chooseTimeStep(const Scene& scene, const CriticalTimeStep& limit, const std::vector<Vec3>& X, Model& model) {
  model.dt_critical = limit.dt;
  model.dt_proven = limit.dt_proven;
  const double tick = 1 / scene.rate_hz;
  // How far the tool may go in a step for the contact to follow without tunnelling (contact/contact_solver.h).
  const double reach = std::min(1e-3, scene.tool.radius / 2);
  if (scene.time_step > 0) {
    const Place place = placeOf(scene, "dynamics.time_step");
    const double substeps = std::round(tick / scene.time_step);
    if (substeps < 1 || std::abs(substeps * scene.time_step - tick) > 1e-6 * tick)
      throw InputError(place, "a tick of " + number(tick) + " s is not a whole number of steps of " + number(scene.time_step) + " s",
                       "use " + number(tick / std::max(1.0, std::ceil(tick / scene.time_step))) + " s, or leave time_step out");
    model.substeps_per_tick = static_cast<int>(substeps);
    if (scene.time_step > limit.dt)
      throw InputError(place, "time_step " + number(scene.time_step) + " s exceeds the critical " + number(limit.dt) +
                                  " s (the stiffest row is the node at " + coordinates(X[limit.worst_node]) + ")",
                       "lower time_step, or coarsen discretization.spacing");
    if (scene.tool_max_speed * scene.time_step > reach * (1 + 1e-9))
      throw InputError(place, "at tool.max_speed the tool travels " + number(scene.tool_max_speed * scene.time_step) +
                                  " m in a step, more than the " + number(reach) + " m that the contact follows",
                       "lower time_step to " + number(reach / scene.tool_max_speed) + " s, or tool.max_speed");
  } else {
    const double longest = std::min(scene.step_safety * limit.dt, reach / scene.tool_max_speed);
    model.substeps_per_tick = std::max(1, static_cast<int>(std::ceil(tick / longest * (1 - 1e-9))));
  }
  model.dt = tick / model.substeps_per_tick;
}

}  // namespace

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
  model.kernel = makeKernelLayout(shape.points, points.X, points.volume, model.point_material, model.materials, nodes, model.patches,
                                  scene.gradient_precision, cloud.X);
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

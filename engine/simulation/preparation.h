#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "approximation/shape_table.h"
#include "discretization/surface/surface_tree.h"
#include "mechanics/critical_time_step.h"
#include "mechanics/essential_boundary.h"
#include "simulation/discretize.h"
#include "simulation/scene.h"

namespace palpate {

/// Called with what is being done and how much of the whole set-up is behind, 0..1. May throw to end it.
/// loadModel calls it again and again within a stage, too.
using Progress = std::function<void(const std::string& what, double fraction)>;

/// What takes long in a model's set-up and follows from the organ, the discretization, the materials and the
/// boundaries alone: what a cache keeps. The rest of the model follows from it in a moment. Names as in Model.
struct Preparation {
  std::vector<Vec3> X;                         // (node_count) m
  std::vector<double> support_radius;          // (node_count) m
  std::vector<double> mass;                    // (node_count) kg
  std::vector<std::array<int, 4>> cells;       // (cell_count)
  double surface_volume = 0, cell_volume = 0;  // m^3
  std::vector<Vec3> point_X;                   // (point_count) m
  std::vector<double> point_volume;            // (point_count) m^3
  std::vector<int> point_material;             // (point_count)
  std::vector<int> point_cell;                 // (point_count)
  std::vector<int> point_other_cell;           // (point_count) or empty
  ShapeTable point_shape, node_shape, skin_shape;
  TriangleSurface skin;                    // refined for contact
  std::vector<ImposedNode> imposed_nodes;  // of EssentialNodes
  std::vector<std::array<int, 3>> facets;  // likewise
  std::vector<Vec3> facet_weight;
  ShapeTable facet_phi;
  CriticalTimeStep limit;
  double added_mass = 0;  // share of the body's own that `mass` has more (scene.mass_scaling)
};

/// Throws InputError naming the place in the scene that can't be used.
/// @param tree  of the organ's closed surface
Preparation prepare(const Scene& scene, const SurfaceTree& tree, const Progress& progress);

/// The same from nodes and cells that are given.
Preparation prepare(const Scene& scene, const SurfaceTree& tree, Discretization discretization,
                    const Progress& progress);

/// All that prepare reads of a scene and the organ's surface, as bytes: equal bytes, equal preparation (by the same
/// program).
std::string preparationKey(const Scene& scene, const TriangleSurface& organ);

/// The scene's materials, ready to use.
std::vector<Material> materialsOf(const Scene& scene);

}  // namespace palpate

#pragma once

#include <cstdint>
#include <vector>

#include "discretization/nodes/node_cloud.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/surface_tree.h"
#include "simulation/scene.h"

namespace palpate {

/// Scene::sharp_interfaces, where there is a border between materials.
bool hasSharpInterfaces(const Scene& scene);

/// Moves nodes that are near a border between materials (materialAt) onto it, along the shortest way that keeps corners
/// at their place, nodes of sharp edges on their edge and surface nodes on the surface; the nearest ones first, and
/// none that would come closer than half a spacing to another. What then remains between two materials is for the cells
/// to decide: each is of the material at its middle.
/// @return how many were moved
/// Test: simulation/sharp_interfaces_test.cpp
int putOnInterfaces(const Scene& scene, const SurfaceTree& organ, const SpacingField& spacing, NodeCloud& cloud);

/// Materials as bits of a number; there is one for each material of the scene.
using MaterialBits = std::uint64_t;
constexpr int max_interface_materials = 64;

/// Of which materials a node has cells: several bits are set at nodes of a border (node_count).
/// @param cell_material  (cell_count)
/// @param node_material  (node_count) of nodes that have no cell
std::vector<MaterialBits> materialsOfNodes(const std::vector<std::array<int, 4>>& cells,
                                           const std::vector<int>& cell_material,
                                           const std::vector<int>& node_material);

}  // namespace palpate

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/surface_tree.h"
#include "mechanics/essential_boundary.h"
#include "scene/scene.h"

namespace palpate {

BoundaryMotion motionOf(const BoundarySpec& spec);

/// Whether there is a node that the boundary imposes.
bool choosesNode(const BoundarySpec& spec, const NodeCloud& cloud, const SurfaceTree& organ);

/// Says that a boundary imposes no node.
[[noreturn]] void refuseEmpty(const Scene& scene, const BoundarySpec& spec);

/// Which nodes are imposed, and how. Throws InputError where two motions contradict.
EssentialNodes chooseImposed(const Scene& scene, const NodeCloud& cloud, const SurfaceTree& organ);

/// Throws InputError where all is fixed, or nothing is and what is prescribed leaves the body a motion as a whole.
void checkHeld(const Scene& scene, const EssentialNodes& essential, std::size_t node_count);

/// Sets the facets that EBCIEM integrates over; returns the places of their quadrature points, m.
/// @param outer  the cells' outer faces
std::vector<Vec3> essentialFacets(const NodeCloud& cloud, const std::vector<std::array<int, 3>>& outer,
                                  EssentialNodes& essential);

/// Bit c set: component c is imposed (node_count).
std::vector<std::uint8_t> imposedComponents(const std::vector<ImposedNode>& nodes, std::size_t node_count);

/// The rows of the imposed nodes from a table with one row per node, and those of points between the nodes from one
/// with one row per point.
ShapeTable rowsOf(const ShapeTable& table, const std::vector<ImposedNode>& nodes, const ShapeTable& point_table = {});

}  // namespace palpate

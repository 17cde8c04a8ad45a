#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "discretization/cells/background_cells.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

/// Formulation::sharp_interfaces, where there is a border between materials: where tissue mixes by a membership there
/// is none.
bool hasSharpInterfaces(const Scene& scene);

/// That, or a region inside of which displacements are imposed: what is held should end where the region does, not at
/// the nodes that happen to lie in it. (A slab of 12 mm that is held up to 2.5 was 15 % too soft on nodes 4 mm apart.)
bool hasBorders(const Scene& scene);

/// Moves nodes that are near a border between materials (materialAt), or of such a region, onto it, along the shortest
/// way that keeps corners at their place, nodes of sharp edges on their edge and surface nodes on the surface; the
/// nearest ones first, and none that would come closer than half a spacing to another. Of a region they come to lie
/// within. What then remains between two materials is for the cells to decide: each is of the material at its middle.
/// @return how many were moved
/// Test: simulation/sharp_interfaces_test.cpp
int putOnInterfaces(const Scene& scene, const SurfaceTree& organ, const SpacingField& spacing, NodeCloud& cloud);

/// How many edges of the cells were mended.
struct Mended {
  int of_materials = 0, of_imposed = 0;
};

/// Closes holes in a border's nodes: where an edge of the cells goes from one material to another, or out of what is
/// imposed, between its ends, a node is added where it crosses, or the node nearest to there moves on to it. A border
/// that cells pierce is a jagged one, at which uniform stresses do not balance. At the organ's surface that of an
/// imposed region is left to the surface's own nodes.
/// @return what was mended; the cells are to be made anew then
Mended closeInterfaces(const Scene& scene, const SurfaceTree& organ, const SpacingField& spacing,
                       const std::vector<std::array<int, 4>>& cells, NodeCloud& cloud);

/// Moves the nodes of curved borders between materials outward where a border bulges, so that the cells of each side,
/// whose faces are flat, have the volume that their material has: as fitToVolume (volume_fit.h) does it at the organ's
/// surface. A core of 1.3 spacings radius is an octagon else, a tenth too small. Flat borders stay to the bit.
void fitInterfaces(const Scene& scene, const SurfaceTree& organ, NodeCloud& cloud, BackgroundCells& cells);

}  // namespace palpate

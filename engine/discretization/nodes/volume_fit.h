#pragma once

#include "discretization/cells/background_cells.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/surface_memory.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// Moves the surface nodes of curved places so that the cells, whose faces are flat, hold the same volume as
/// the body: outward where the surface bulges, inward where it is hollow, by about the mean height of the
/// surface above the facets (0.13 h^2 / radius of curvature; never more than 0.15 facet edges). The loss of
/// volume to flat faces, 0.4-2 % at usual spacings, falls below 0.02 %. It is removed where it arises, not by one
/// factor for the whole body. Scaling the volumes of the integration points instead would break the divergence theorem
/// of the cells. Nodes on flat faces do not leave their plane, those between two such faces do not move off
/// their edge.
///
/// @param cloud  X of surface nodes is moved
/// @param cells  volumes are updated; every cell keeps at least a fifth of its volume
/// @param memory of this surface, or null
/// Test: discretization/nodes/volume_fit_test.cpp
void fitToVolume(NodeCloud& cloud, BackgroundCells& cells, const SurfaceTree& surface, SurfaceMemory* memory = nullptr);

/// Where a cell would be left with less than a fifth of its first volume its nodes stay where they are.
/// @param first_volume  m^3 (cell_count)
/// @param from, to      m (node_count); `to` is that of the nodes that may go
void holdShrinking(const BackgroundCells& cells, const std::vector<double>& first_volume, const std::vector<Vec3>& from,
                   std::vector<Vec3>& to);

}  // namespace palpate

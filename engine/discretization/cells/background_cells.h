#pragma once

#include <array>
#include <vector>

#include "base/types.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/surface_memory.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// Tetrahedra that fill the body and carry its integration points. They need no quality: the
/// approximation is meshless, and a cell only says which part of the volume a point stands for.
struct BackgroundCells {
  std::vector<std::array<int, 4>>
      cells;                   // (cell_count) nodes in ascending order, two swapped where the orientation needs it
  std::vector<double> volume;  // (cell_count) m^3, > 0
  double total_volume = 0;     // m^3, sum of the cells' volumes
  double surface_volume = 0;   // m^3, of the body's own surface

  /// Relative error of the cells' volume: negative where the cells fill less than the body.
  double volumeError() const { return total_volume / surface_volume - 1; }
};

/// Delaunay tetrahedra of the nodes, less those of which more than half lies outside the surface
/// (judged by 15 points inside each that is near it), those with an edge across air that is narrower than nodes are
/// apart, and less the slivers.
///
/// The cells' flat faces cut the corners of curved surfaces: on a sphere of radius r the loss is about
/// 0.4 (h/r)^2 of the volume. fitToVolume (volume_fit.h) removes this loss.
/// Throws InputError where all nodes lie in one plane.
/// @param memory  of this surface, or null
/// Test: discretization/cells/background_cells_test.cpp
BackgroundCells makeBackgroundCells(const NodeCloud& cloud, const SurfaceTree& surface,
                                    SurfaceMemory* memory = nullptr);

/// The cells' faces that belong to one cell only, counter-clockwise seen from outside.
/// Sorted by their nodes' numbers.
std::vector<std::array<int, 3>> boundaryFacets(const std::vector<std::array<int, 4>>& cells);

/// Cells that share a face, the lower number first; sorted by the faces' nodes' numbers.
std::vector<std::array<int, 2>> neighbouringCells(const std::vector<std::array<int, 4>>& cells);

/// The means of the cells' vertices, m.
std::vector<Vec3> centroids(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells);

/// Recomputes volume and total_volume from moved nodes.
void updateVolumes(BackgroundCells& cells, const std::vector<Vec3>& X);

}  // namespace palpate

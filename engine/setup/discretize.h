#pragma once

#include <array>
#include <functional>
#include <vector>

#include "discretization/cells/background_cells.h"
#include "discretization/nodes/node_cloud.h"
#include "discretization/surface/refine_surface.h"
#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

struct Discretization {
  NodeCloud cloud;
  BackgroundCells cells;
};

/// Throws InputError where a body of so many m^3, with a surface of so many m^2, would get more nodes than the set-up
/// can hold, or more faces under the tool than refineSurface makes. Costs nothing, so ask before the body is made.
void checkCounts(const Scene& scene, double volume, double area);

/// The scene's nodes and cells; nodes in slices along the organ (slicedOrder). Throws InputError where the spacing
/// is too fine.
/// @param progress  called with the share that is done, 0..1; may throw
Discretization discretize(const Scene& scene, const SurfaceTree& organ, const std::function<void(double)>& progress);

/// The skin's vertices sample the contact pressure: 0.35 tool radii is what contact/skin.h asks for, and
/// where the nodes are denser than the tool is wide, a third of their spacing keeps up with them.
/// Throws InputError where more than `max_triangles` would be needed.
TriangleSurface refineForContact(const Scene& scene, const TriangleSurface& organ,
                                 int max_triangles = max_refined_triangles);

/// R_j = factor * (mean length of the cell edges at node j), m (node_count).
std::vector<double> supportRadii(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells,
                                 double factor);

}  // namespace palpate

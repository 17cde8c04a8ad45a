#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/types.h"
#include "discretization/nodes/spacing_field.h"
#include "discretization/surface/feature_edges.h"
#include "discretization/surface/surface_tree.h"

namespace palpate {

/// The nodes of a body, irregular and well spread.
struct NodeCloud {
  std::vector<Vec3> X;                   // (node_count) m; corners, edges, faces, then the interior
  std::vector<std::uint8_t> on_surface;  // (node_count) 1 on the body's surface
};

/// Fills a body with nodes: on the surface's corners, along its sharp edges, over its faces, inside.
/// Each of these stages is a blue-noise sample (dart throwing with a radius that shrinks until the wanted number of
/// nodes is placed), then relaxed by short-range repulsion while the nodes of earlier stages are held in place.
///
/// With h the spacing field: no two nodes are closer than 0.5 h (h the mean of theirs) and no inner
/// node is closer to the surface than 0.5 h; where two parts of the surface or two corners come closer than
/// that, one of the conflicting nodes is left out. Only across air, as of a slit, they may be as near as it is narrow:
/// where it is narrower than 0.5 h, or than `paired_air`, nodes stand in pairs straight across it, so that each side
/// has its own, and cells (background_cells.h) end at the air. Where the surface's parts are at least some h apart, the
/// closest pair is at 0.65-0.83 h, the mean nearest neighbour at 0.85-0.91 h and the mean edge of the cells
/// at 1.02-1.07 h. Uniform spacing gives V/(0.7 h^3) + k A/h^2 nodes (V volume, A area), with k measured
/// 0.52-0.63 on fine clouds and up to 0.78 on coarse ones, whose edges weigh more.
///
/// @param surface  closed, outward (see surface_check.h)
/// @param rims     closed curves on the surface that get nodes as sharp edges do: the borders of imposed regions
/// @param progress called now and then with the share that is done, 0..1; may throw
/// @param paired_air  m, wider air than half a spacing that has pairs, too
/// @param seed     another seed, another cloud of the same quality; the same seed gives the same bits
/// Throws InputError (place of the spacing field) for spacings that are not positive, exceed the body's
/// smallest extent, or would need more than 500,000 nodes.
///
/// Cost: ~ node_count; a few seconds on one core for 30,000 nodes.
///
/// Test: discretization/nodes/node_cloud_test.cpp
NodeCloud makeNodeCloud(const SurfaceTree& surface, const SpacingField& spacing, unsigned seed,
                        const std::vector<FeatureEdges::Chain>& rims = {},
                        const std::function<void(double)>& progress = {}, double paired_air = 0);

}  // namespace palpate

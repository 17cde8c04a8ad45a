#pragma once

#include <functional>

#include "discretization/surface/surface_tree.h"
#include "imaging/isosurface.h"

namespace palpate {

/// Called with the share that is done, 0..1; may throw to end it.
using Share = std::function<void(double)>;

/// Distance to a surface that need not be closed, m, negative inside, on a grid of `cell` that reaches three cells
/// beyond it. Inside is where the surface's generalised winding number (Jacobson et al. 2013, computed as by Barill et
/// al. 2018) is above 1/2: holes are spanned smoothly, sheets that overlap are united. Only near the surface, or where
/// the winding number is in doubt, each node is asked for; elsewhere the distance is cut off at three cells.
/// The same bits for any number of threads. Costs ~ nodes near the surface * log(face count).
SampledField signedField(const SurfaceTree& surface, double cell, const Share& progress = {});

/// Nodes that such a grid has.
double fieldNodes(const Box3& box, double cell);

/// Makes regions of the body that are small beside its largest one, by their number of nodes, part of the outside, and
/// hollows that are small beside it part of the body. Counts what it changed.
struct SmallRegions {
  int parts = 0, hollows = 0;
  double part_share = 0;  // of all inner nodes
};
SmallRegions removeSmallRegions(SampledField& field, double least_part_share, double least_hollow_share);

}  // namespace palpate

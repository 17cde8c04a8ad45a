#pragma once

#include "discretization/surface/surface_tree.h"
#include "simulation/build_model.h"

namespace palpate {

/// The second half of buildModel: what is quick, and what depends on rate, step and tool. Throws InputError naming the
/// place in the scene that can't be used.
/// @param tree  of the organ's closed surface
Model finish(const Scene& scene, const SurfaceTree& tree, Preparation preparation, const Progress& report);

}  // namespace palpate

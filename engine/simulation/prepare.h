#pragma once

#include "discretization/surface/surface_tree.h"
#include "simulation/build_model.h"
#include "simulation/discretize.h"
#include "simulation/preparation.h"

namespace palpate {

/// The first half of buildModel, from nodes and cells on. Throws InputError naming the place in the scene that can't be
/// used.
/// @param tree  of the organ's closed surface
Preparation prepare(const Scene& scene, const SurfaceTree& tree, Discretization discretization,
                    const Progress& progress);

}  // namespace palpate

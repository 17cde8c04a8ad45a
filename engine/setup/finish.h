#pragma once

#include "discretization/surface/surface_tree.h"
#include "setup/build_model.h"
#include "setup/prepare.h"

namespace palpate {

/// The second half of buildModel: what is quick, and what depends on rate, step and tool. Throws InputError naming the
/// place in the scene that can't be used.
/// @param tree    of the organ's closed surface
/// @param common  of a place; null: the scene's body is on its own
Model finish(const Scene& scene, const SurfaceTree& tree, Preparation preparation, const Progress& report,
             const CommonToPlaces* common = nullptr);

/// The skin as the contact reads it, but for its rows.
SkinModel skinOf(const Scene& scene, const TriangleSurface& surface);

}  // namespace palpate

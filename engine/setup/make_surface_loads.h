#pragma once

#include "discretization/surface/surface_tree.h"
#include "model/body.h"
#include "model/surface_loads.h"

namespace palpate {

/// The loads of body.scene. Throws InputError where a load's region holds no skin, or held skin alone.
/// @param organ  whose surface the regions choose parts of: of each place on the cells' faces the nearest
SurfaceLoads makeSurfaceLoads(const Body& body, const SurfaceTree& organ);

}  // namespace palpate

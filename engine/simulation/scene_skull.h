#pragma once

#include "contact/skull.h"
#include "discretization/surface/surface_tree.h"
#include "simulation/scene.h"

namespace palpate {

/// The scene's skull, or none. Throws InputError where the organ reaches through it at rest.
Skull skullOf(const Scene& scene, const SurfaceTree& organ, const SkinModel& skin, double young_modulus);

}  // namespace palpate

#pragma once

#include "contact/rigid_bodies.h"
#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

/// The scene's rigid bodies. Throws InputError where the organ reaches into one of them at rest.
/// @param of_body  as addRigidBody's
RigidBodies rigidBodiesOf(const Scene& scene, const SurfaceTree& organ, const SkinModel& skin,
                          const std::vector<int>& of_body, const SpacingField& spacing);

/// The solid that a region is. @pre  a half-space, box, sphere or cylinder
RigidShape solidOf(const Region& region);

/// Bound on how fast a body that moves goes where it can touch the organ, m/s.
double largestSpeed(const RigidSpec& spec);

/// The name of the body that [skull] makes.
inline constexpr const char* skull_name = "skull";

}  // namespace palpate

#pragma once

#include "app/render/solid_mesh.h"
#include "scene/scene.h"

namespace palpate::app {

/// A rigid body where it is at rest, m. A half-space is a plate beneath its plane, somewhat larger than the organ; what
/// encloses the organ would hide it, and is empty.
/// @param centre, radius  of a ball around the organ at rest, m
SolidMesh rigidMesh(const RigidSpec& body, const Vec3& centre, double radius);

}  // namespace palpate::app

#pragma once

#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

/// True where x (m) lies in the region or on its border. A shell is measured from the organ's surface.
bool contains(const Region& region, const Vec3& x, const SurfaceTree& organ);

/// Index into scene.materials: of several, the last whose region holds x (m).
int materialAt(const Scene& scene, const Vec3& x, const SurfaceTree& organ);

}  // namespace palpate

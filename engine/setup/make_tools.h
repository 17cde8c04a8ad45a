#pragma once

#include "contact/tool_set.h"
#include "discretization/surface/surface_tree.h"
#include "scene/scene.h"

namespace palpate {

/// What a scene's tools make of a model: where each starts, how far it is from the skin, its bodies.
/// Throws InputError where a tool starts inside the organ.
ToolSet makeToolSet(const Scene& scene, const SurfaceTree& organ, const TriangleSurface& skin);

}  // namespace palpate

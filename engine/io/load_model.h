#pragma once

#include "simulation/build_model.h"

namespace palpate {

/// The organ's closed surface: the scene's file, read, scaled and checked, or its analytic solid
/// triangulated finely enough for spacing and tool. Throws InputError with file and line.
TriangleSurface organSurface(const Scene& scene);

/// organSurface and buildModel: from a scene that was read to a model that is ready to run.
Model loadModel(const Scene& scene, const Progress& progress = {});

}  // namespace palpate

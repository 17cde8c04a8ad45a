#pragma once

#include "io/model_cache.h"
#include "simulation/build_model.h"

namespace palpate {

/// The organ's closed surface: the scene's file, read, scaled and checked, or its analytic solid
/// triangulated finely enough for spacing and tool. Throws InputError with file and line.
TriangleSurface organSurface(const Scene& scene);

/// organSurface and buildModel: from a scene that was read to a model that is ready to run. What takes long is taken
/// from the cache, or made and kept there; the model has the same bits either way.
Model loadModel(const Scene& scene, const Progress& progress = {}, const ModelCache& cache = ModelCache());

}  // namespace palpate

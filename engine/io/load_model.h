#pragma once

#include <functional>
#include <memory>
#include <string>

#include "io/model_cache.h"
#include "setup/build_model.h"
#include "setup/place_source.h"

namespace palpate {

/// The organ's closed surface: the scene's file, read, scaled and checked (or, with `repair`, repaired), or its
/// analytic solid triangulated finely enough for spacing and tool. Throws InputError with file and line.
TriangleSurface organSurface(const Scene& scene);

/// What to say of an organ whose bounding box's longest edge is below 1 mm or above 3 m: its unit is probably
/// another one. Empty for all others.
std::string sizeWarning(const Scene& scene, const TriangleSurface& surface);

/// organSurface and buildModel: from a scene that was read to a model that is ready to run. What takes long is taken
/// from the cache, or made and kept there; the model has the same bits either way. Scenes without set_up_values,
/// which no file was read for, are not kept.
///
/// A cloud that follows the tool is the one for where the tools are, and stays there: for what happens at one place.
/// The model's scene tells how it is made (spacing, a ball around each tool), without `follow`.
/// @param warn  gets what is allowed but probably not meant (sizeWarning), before the set-up takes time
/// @param at    where the tools are then, by the model that they start on; empty: where they start
Model loadModel(const Scene& scene, const Progress& progress = {}, const ModelCache& cache = ModelCache(),
                const std::function<void(const std::string&)>& warn = {},
                const std::function<ToolPostures(const Model&)>& at = {});

/// The same of a scene whose cloud follows the tool (`[discretization] follow`): its places, and the one at which the
/// tools start. Nothing is told of places that can't be kept or read.
std::shared_ptr<PlaceSource> loadFollowing(const Scene& scene, const Progress& progress = {},
                                           const ModelCache& cache = ModelCache(),
                                           const std::function<void(const std::string&)>& warn = {});

}  // namespace palpate

#pragma once

#include <optional>

#include "app/run/options.h"
#include "app/run/result_folder.h"
#include "scene/scene.h"

namespace palpate::app {

/// The files that the run will write, opened or tried before anything takes time. Throws InputError where the run reads
/// one of them, or would write two things into it; std::runtime_error where one can't be written.
std::optional<ResultFolder> openResults(const Options& options, const Scene& scene);

}  // namespace palpate::app

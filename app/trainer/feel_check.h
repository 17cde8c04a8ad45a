#pragma once

#include <string>

#include "app/trainer/lumps.h"

namespace palpate::app {

/// How deep a trainee is expected to press with this tool, m: before the sides of a ball lie on the skin.
double workingDepth(const Scene& scene);

/// Throws InputError at the lump that can't be felt at the working depth (LumpFeel), with what to change. Each lump is
/// pressed and the tissue beside it (about a second); what came of it is kept in `cache_folder` for the next start.
/// @param cache_folder  "": nothing is kept
void requireFelt(const Model& model, const std::string& cache_folder);

}  // namespace palpate::app

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/trainer/lumps.h"

namespace palpate::app {

/// How deep a trainee is expected to press with this tool, m: before the sides of a ball lie on the skin.
double workingDepth(const Scene& scene);

/// A lump that can't be felt: where the scene says it, and by how much it misses, and what to do.
struct Unfelt {
  SourceLocation place;
  std::string problem, advice;
};

/// The first lump whose centre is not in the organ, if any.
std::optional<Unfelt> outsideLump(const Model& model);

/// That, or the first lump that can't be felt at the working depth (LumpFeel), if any. Each lump is pressed and the
/// tissue beside it (about a second); what came of it is kept in `cache_folder` for the next start.
/// @param cache_folder  "": nothing is kept
/// @param progress  as feelLumps
std::optional<Unfelt> unfeltLump(const TaskBody& body, const std::string& cache_folder,
                                 const std::function<void(double)>& progress = {});

/// Throws InputError at that lump, with what to change.
void requireFelt(const TaskBody& body, const std::string& cache_folder,
                 const std::function<void(double)>& progress = {});

}  // namespace palpate::app

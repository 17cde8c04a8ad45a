#pragma once

#include "mtled/identify/identify_command.h"

namespace palpate::tools {

/// `mtled identify --regions`: one number of each of the scene's materials, so that presses at rest at many places have
/// the forces that were measured, and leaves identify.json and identify.png. By the method of Gauss and Newton, with
/// derivatives by the adjoint (sensitivity.h): an iteration costs about two equilibria for each press, however many
/// regions there are.
/// @return as identifyCommand
int identifyRegions(const IdentifyOptions& options);

}  // namespace palpate::tools

#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

struct IdentifyOptions {
  std::string scene;                    // file, or the name of one in assets/scenes
  std::string measured;                 // CSV (force_curve.h)
  std::vector<std::string> parameters;  // scene keys of the material's law, at most two; empty: its first
  int material = 0;                     // in the scene's order
  bool regions = false;                 // one parameter of all materials, from presses at many places
  double seconds = 0;                   // in which the simulated tool is pressed in; 0: from the curve's times
  int threads = 0;                      // 0: one per core
  std::string out;                      // folder; "": out/<scene>_identify
};

/// Finds the parameters of a material (or of all: identify_regions.h) with which the scene gives a measured force
/// curve, and leaves identify.json and identify.png in the folder. On a fine scene the search runs on a coarser cloud
/// (coarse_to_fine.h).
/// @return 0 found; 1 not: no convergence, or the parameters can't be told apart; 3 found, but doubted: the scene can't
///         follow the curve, or the curve had not settled
/// Throws InputError for unusable input, std::runtime_error where the model can't follow the curve or a file can't be
/// written.
int identifyCommand(const IdentifyOptions& options);

}  // namespace palpate::tools

#pragma once

#include <string>

namespace palpate::tools {

struct FitOptions {
  std::string scene;        // file, or the name of one in assets/scenes
  std::string out;          // scene file to write; "": <scene>_<rate>hz.toml in out
  std::string json;         // "": none
  std::string tool_script;  // "": the built-in indentation
  double rate_hz = 0;       // 0: the scene's
  int cores = 0;            // for the physics; 0: all
  bool uniform = false;     // the same spacing everywhere: for a tool that goes anywhere
  bool resume = false;      // keep what was tried already
};

/// Finds the most accurate setting of a scene that holds a rate on this machine and writes it as a scene file: the
/// finest spacing
/// that a tick has time for, at several supports, with a point for each cell or less, evenly and with nodes dense
/// where the tool works; of these the one closest to a converged
/// solution. Prints what it expects of the force's error, and how much of a tick is left.
/// What was tried is kept beside the scene: OUT.fit.json and OUT.reference.json. Where the real-time loop does not hold
/// the rate, what was tried there last is written all the same, and its first line says that it is not confirmed.
/// @return 0 done, 1 no setting holds the rate, or interrupted
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int fitCommand(const FitOptions& options);

}  // namespace palpate::tools

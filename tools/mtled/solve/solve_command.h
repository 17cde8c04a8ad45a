#pragma once

#include <string>

namespace palpate::tools {

struct SolveOptions {
  std::string scene;        // file, or the name of one in assets/scenes
  std::string out;          // folder; "": out/<scene's name>
  std::string tool_script;  // "": no tool
  int threads = 0;          // 0: one per core
  bool resume = false;      // go on from the folder's checkpoint
  bool use_cache = false;   // keep the set-up for the next start
};

/// Solves a scene as its [solve] table says and leaves force.csv, probes.csv, solution.pvd with its VTU files,
/// checkpoint.bin and report.json in the folder. SIGINT leaves what there is.
/// @return 0 solved, 1 not converged, diverged or interrupted (report.json says which)
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int solveCommand(const SolveOptions& options);

}  // namespace palpate::tools

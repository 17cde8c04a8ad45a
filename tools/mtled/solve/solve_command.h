#pragma once

#include <string>

#include "base/types.h"

namespace palpate {
struct Model;
}

namespace palpate::tools {

struct SolveOptions {
  std::string scene;        // file, the name of one in assets/scenes, or a case's folder (mtled import)
  std::string out;          // folder; "": out/<scene's name>, or `solution` in the case's
  std::string tool_script;  // of the first tool; "": the scene's own
  int threads = 0;          // 0: one per core
  bool resume = false;      // go on from the folder's checkpoint
  bool strict = false;      // a result that is doubted is no success
  bool use_cache = false;   // keep the set-up for the next start
};

/// Solves a scene as its [solve] table says and leaves force.csv, probes.csv, solution.pvd with its VTU files,
/// checkpoint.bin and report.json in the folder. SIGINT leaves what there is.
/// @return 0 solved, 1 not converged, diverged or interrupted (report.json says which), 3 doubted (options.strict)
/// Throws InputError for unusable input, std::runtime_error where a file can't be written.
int solveCommand(const SolveOptions& options);

/// Displacement parameters (m) that solveCommand left in a folder, without a tool (node_count).
/// Throws InputError where there is none, or it is of another model or load.
AlignedVector<Double4> solutionOf(const Model& model, const std::string& folder);

}  // namespace palpate::tools

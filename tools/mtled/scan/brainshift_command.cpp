#include "mtled/scan/brainshift_command.h"

#include <filesystem>

#include "base/input_error.h"
#include "mtled/scan/warp_command.h"
#include "mtled/solve/solve_command.h"

namespace palpate::tools {

int brainshiftCommand(const ImportScanOptions& options, const std::string& like) {
  if (options.electrodes.empty())
    throw InputError({}, "nothing moves the organ", "give --electrodes FILE: where points of its surface went");
  ImportScanOptions import = options;
  if (import.out.empty()) import.out = (std::filesystem::path("out") / "brainshift").string();
  if (const int code = importScan(import); code != 0) return code;
  SolveOptions solve;
  solve.scene = import.out;
  solve.use_cache = true;
  if (const int code = solveCommand(solve); code != 0) return code;
  WarpOptions warp;
  warp.folder = import.out;
  warp.image = import.scan;
  warp.like = like;
  warp.assume_ras = import.assume_ras;
  return warpCommand(warp);
}

}  // namespace palpate::tools

#pragma once

#include <string>

#include "mtled/bench/bench_report.h"

namespace palpate::tools {

struct BenchOptions {
  bool device = false;  // whether simulated haptic devices are stable, instead of the kernels
  bool quick = false;   // 1k and 5k nodes only
  double seconds = 0;   // for each figure; 0: 0.5, or 0.15 of a quick run
  std::string json;     // file for the results, or ""
  std::string plot;     // PNG for the roofline, or ""
  bool check = false;   // a promise that is missed is a failure
};

/// Measures the machine's ceilings and the force kernels beside them, and prints tables and verdicts; or how
/// simulated haptic devices do.
/// @return 0; 1 where a kernel's forces are wrong, or with `check` where a promise is missed
/// Throws InputError for an option out of range, std::runtime_error where a file can't be written.
int benchCommand(const BenchOptions& options);

/// What benchCommand returns for what it found.
int benchExitCode(const BenchReport& report, bool check);

}  // namespace palpate::tools

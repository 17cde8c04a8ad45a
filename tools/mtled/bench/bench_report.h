#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "mtled/bench/machine_ceilings.h"
#include "mtled/report/case_result.h"

namespace palpate::tools {

/// One kernel on one body with so many threads. Times and counts are per integration point and evaluation (= step).
/// NaN stands for what does not apply.
struct BenchRow {
  std::string
      kernel;  // "plain Eigen", "ten-line reference", "blocks", "blocks, node patches", "whole step" (with patches)
  std::string precision;        // "double", "float32", "int16"
  std::string instruction_set;  // nameOf(InstructionSet)
  int threads = 1;
  double best_ns = 0, median_ns = 0;
  double force_error = 0;  // |f - f_reference| / |f_reference|, of the whole field
  double error_limit = 0;
  double bytes = 0, useful_flops = 0, executed_flops = 0;
  double gb_per_s = 0, gflop_per_s = 0;  // reached by the best time; useful flops
  std::string ceiling;                   // which binds: "FMA", "L2", "L3" or "DRAM"
  double ceiling_ns = 0;                 // no faster than this by that ceiling
  double share = 0;                      // of the ceiling that is reached: ceiling_ns / best_ns

  bool wrong() const { return force_error > error_limit; }  // NaN: nothing was compared
};

struct BenchBodyResult {
  std::string name;  // "5k"
  int nodes = 0, points = 0;
  double mean_support = 0;
  double setup_seconds = 0;
  std::vector<BenchRow> rows;

  /// Null where there is no such row.
  const BenchRow* find(const std::string& kernel, const std::string& precision, const std::string& instruction_set,
                       int threads) const;
  const BenchRow* plain(int threads) const;  // the baseline, whatever it was compiled for
};

struct BenchReport {
  std::string build;  // buildInfo()
  std::string command;
  Machine machine;
  std::vector<Ceilings> ceilings;  // one per thread count
  std::vector<BenchBodyResult> bodies;

  /// All rows' forces agree with the reference.
  bool right() const;
};

/// What was promised of the kernel, and what came out.
struct Verdict {
  Bound bound;
  std::string missing;  // why it can't be judged here, or ""

  std::string text() const;  // "held", "missed" or "not measured"
};

/// The promises at about 5,000 nodes and 20,000 points, on rows of the widest instruction set: float32 in 60 ns and
/// int16 in 45 ns on one AVX-512 core, node patches for at most 40 % more, 1.7 times as fast on two threads, 5 times
/// as fast as
/// the plain kernel, within twice the time that the binding ceiling allows.
std::vector<Verdict> verdictsOf(const BenchReport& report);

/// Build, machine and its ceilings.
void printMachine(std::ostream& out, const BenchReport& report);
/// A table of times and one of costs beside the ceilings.
void printBody(std::ostream& out, const BenchBodyResult& body);
void printVerdicts(std::ostream& out, const BenchReport& report);

/// All of it in JSON, verdicts included; NaN as null.
std::string jsonOf(const BenchReport& report);

}  // namespace palpate::tools

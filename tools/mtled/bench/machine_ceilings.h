#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/instruction_set.h"

namespace palpate::tools {

/// What this computer is, as far as a kernel's speed depends on it.
struct Machine {
  std::string processor;     // "AMD EPYC ..."; "unknown" where /proc does not say
  int cores = 1;             // hardware threads that this process may use
  std::size_t l2_bytes = 0;  // of one core; 0: unknown
  std::size_t l3_bytes = 0;  // shared; 0: none, or unknown
};

/// From /proc/cpuinfo, the scheduler's affinity mask and /sys/devices/system/cpu (else sysconf).
Machine thisMachine();

/// What the compiler was told to use for everything but the hot kernel.
InstructionSet compiledInstructionSet();

/// A place where a working set can lie, and how fast all threads together read from it.
struct MemoryLevel {
  std::string name;          // "L2", "L3", "DRAM"
  std::size_t capacity = 0;  // bytes, of all threads together; 0: no limit
  double gb_per_s = 0;       // 1e9 bytes per second
};

/// How fast `threads` cores can go at best: no kernel is faster than these.
struct Ceilings {
  int threads = 1;
  std::vector<double> fma_gflops;   // (InstructionSet) float32, multiply and add counted apart; 0: not supported
  std::vector<MemoryLevel> levels;  // near to far, DRAM last

  double mostGflops() const;  // of the widest instruction set
  /// The nearest level that holds so many bytes.
  const MemoryLevel& levelOf(double bytes) const;
};

/// Measures the ceilings of 1 .. n cores: independent chains of multiply-adds that stay in registers (fused where
/// the set has that), and
/// forward reads with the hot kernel's prefetch distance. Memory is written before it is read, so that no level is
/// the kernel's zero page.
///
/// All figures take turns in short rounds until each has had `seconds`, and each is the best of its rounds:
/// a neighbour on the machine, a clock that is still rising or one that falls with wide registers costs
/// rounds, not figures.
///
/// @param thread_counts  each at least 1
/// Test: tools/bench_command_test.cpp
std::vector<Ceilings> measureCeilings(const Machine& machine, const std::vector<int>& thread_counts, double seconds);

}  // namespace palpate::tools

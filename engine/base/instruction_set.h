#pragma once

#include <string>
#include <vector>

namespace palpate {

/// Instruction sets that the hot kernel is compiled for, narrowest first. Their results differ by rounding: the
/// plain one
/// has no fused multiply-add, and the compiler fuses a little differently in the others (seen in the Ogden material).
enum class InstructionSet {
  Plain,   // the architecture's baseline (x86-64: SSE2)
  Avx2,    // x86-64-v3: AVX2 and FMA
  Avx512,  // x86-64-v4
};

/// "plain", "avx2", "avx512".
const char* nameOf(InstructionSet set);

/// Those that this processor and system can run, narrowest first.
std::vector<InstructionSet> supportedInstructionSets();

/// What the kernel runs with: the widest supported, or what the environment variable PALPATE_KERNEL names.
/// Throws InputError when that is unknown or not supported here.
InstructionSet chosenInstructionSet();

}  // namespace palpate

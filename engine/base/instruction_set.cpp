#include "base/instruction_set.h"

#include <cstdlib>

#include "base/input_error.h"

namespace palpate {

const char* nameOf(InstructionSet set) {
  switch (set) {
    case InstructionSet::Avx512:
      return "avx512";
    case InstructionSet::Avx2:
      return "avx2";
    case InstructionSet::Plain:
      break;
  }
  return "plain";
}

std::vector<InstructionSet> supportedInstructionSets() {
  std::vector<InstructionSet> sets{InstructionSet::Plain};
#if defined(__x86_64__)
  // All that x86-64-v3 and -v4 may use; the checks include the system's support of the wide registers.
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
      __builtin_cpu_supports("bmi2")) {
    sets.push_back(InstructionSet::Avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
      sets.push_back(InstructionSet::Avx512);
  }
#endif
  return sets;
}

InstructionSet chosenInstructionSet() {
  const auto supported = supportedInstructionSets();
  const char* wanted = std::getenv("PALPATE_KERNEL");
  if (!wanted || *wanted == '\0') return supported.back();
  std::string names;
  for (const InstructionSet set : supported) {
    if (std::string(nameOf(set)) == wanted) return set;
    names += (names.empty() ? "" : ", ") + std::string(nameOf(set));
  }
  for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512})
    if (std::string(nameOf(set)) == wanted)
      throw InputError({},
                       "PALPATE_KERNEL=" + std::string(wanted) + ": this processor does not have these instructions",
                       "leave it unset or choose from: " + names);
  throw InputError({}, "PALPATE_KERNEL=" + inQuotes(wanted) + " is no kernel",
                   "leave it unset or choose from: " + names);
}

}  // namespace palpate

#include "base/build_info.h"

#include "base/input_error.h"
#include "base/instruction_set.h"
#include "source_identity.h"  // made by tools/source_identity.cmake

namespace palpate {

std::string buildInfo() {
  std::string s = "palpate " PALPATE_VERSION ", gcc " __VERSION__ ", " PALPATE_BUILD_TYPE;
#if PALPATE_NATIVE
  s += ", -march=native";
#endif
  try {
    s += std::string(", kernel ") + nameOf(chosenInstructionSet());
  } catch (const InputError& e) {
    s += std::string(", no kernel (") + e.what() + ")";
  }
  if (PALPATE_SANITIZE[0] != '\0') s += ", sanitizers: " PALPATE_SANITIZE;
  return s;
}

std::string sourceIdentity() { return PALPATE_SOURCE_IDENTITY; }

std::string sourceFolder() { return PALPATE_SOURCE_FOLDER; }

}  // namespace palpate

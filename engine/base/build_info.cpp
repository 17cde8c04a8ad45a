#include "base/build_info.h"

#include "source_identity.h"  // made by tools/source_identity.cmake

namespace palpate {

std::string buildInfo() {
  std::string s = "palpate " PALPATE_VERSION ", gcc " __VERSION__ ", " PALPATE_BUILD_TYPE;
#if PALPATE_NATIVE
  s += ", -march=native";
#endif
#if defined(__AVX512F__)
  s += ", AVX-512";
#elif defined(__AVX2__)
  s += ", AVX2";
#else
  s += ", baseline x86-64";
#endif
  if (PALPATE_SANITIZE[0] != '\0') s += ", sanitizers: " PALPATE_SANITIZE;
  return s;
}

std::string sourceIdentity() { return PALPATE_SOURCE_IDENTITY; }

}  // namespace palpate

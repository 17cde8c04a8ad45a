// One reader under clang's libFuzzer (see CMakeLists.txt): PALPATE_FUZZ_READER is its name.

#include <cstddef>
#include <cstdint>
#include <string>

#include "fuzz/reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate::fuzz;
  static const Reader& reader = readerOf(PALPATE_FUZZ_READER);
  takes(reader, std::string(reinterpret_cast<const char*>(data), size));  // what it throws ends the program
  return 0;
}

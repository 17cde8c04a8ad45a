#include "base/build_info.h"

#include <dlfcn.h>

#include <cstdlib>
#include <filesystem>

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

std::string programVersion() { return PALPATE_VERSION; }

std::string sourceIdentity() { return PALPATE_SOURCE_IDENTITY; }

std::string sourceFolder() { return PALPATE_SOURCE_FOLDER; }

std::string dataFolder() {
  namespace fs = std::filesystem;
  if (const char* wanted = std::getenv("PALPATE_DATA_DIR"); wanted && *wanted) return wanted;
  Dl_info module{};
  std::error_code ignored;
  if (dladdr(reinterpret_cast<const void*>(&dataFolder), &module) != 0 && module.dli_fname != nullptr) {
    // lib/ or bin/, or a folder for the processor in lib/. Of a program's name, only what the system keeps is whole.
    const fs::path file = fs::canonical(module.dli_fname, ignored);
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    for (const fs::path& from : {file, program})
      for (const char* up : {"..", "../.."}) {
        if (from.empty()) continue;
        const fs::path folder = (from.parent_path() / up / "share/palpate").lexically_normal();
        if (fs::is_directory(folder / "assets/scenes", ignored)) return folder.string();
      }
  }
  return sourceFolder();
}

}  // namespace palpate

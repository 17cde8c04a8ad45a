#include "mtled/import/import_scan.h"

#include <cctype>

#include "base/input_error.h"
#include "io/surface_file.h"

namespace palpate::tools {

bool isScan(const std::string& file) {
  std::string name = file;
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name.ends_with(".nii") || name.ends_with(".nii.gz");
}

int importScan(const ImportOptions& options) {
  throw InputError({options.file}, "a scan can't be imported yet",
                   "export the organ's surface (" + surfaceFormats() + ") from the program that segmented it");
}

}  // namespace palpate::tools

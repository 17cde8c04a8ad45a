#pragma once

#include "mtled/import/import_command.h"

namespace palpate::tools {

/// Whether importCommand takes the file for a scan: .nii or .nii.gz.
bool isScan(const std::string& file);

/// importCommand for a scan.
int importScan(const ImportOptions& options);

}  // namespace palpate::tools

#pragma once

#include "mtled/scan/import_scan.h"

namespace palpate::tools {

/// importScan, solveCommand and warpCommand of the scan, one after the other: from a scan and measured points to the
/// scan as it is now (paper section 5). Ctrl-C ends it after what is done.
/// @param like  NIfTI whose voxels the results have; "": the scan's
/// @return 0, or the first other code of the three
/// Throws as they do; InputError without electrodes.
int brainshiftCommand(const ImportScanOptions& options, const std::string& like);

}  // namespace palpate::tools

#pragma once

#include <string>

#include "imaging/phantom.h"

namespace palpate::tools {

struct PhantomCommandOptions {
  PhantomOptions phantom;
  std::string out = "out/phantom";  // folder
};

/// Writes scan.nii.gz, mask.nii.gz and electrodes.csv (RAS, mm) into a folder. Throws std::runtime_error.
void writeForImport(const Phantom& phantom, const std::string& folder);

/// Makes test data: scan, mask, labels and true shares of tissue as NIfTI, electrodes before and after as CSV (RAS,
/// mm).
/// @return 0. Throws std::runtime_error where a file can't be written.
int phantomCommand(const PhantomCommandOptions& options);

}  // namespace palpate::tools

#pragma once

#include <string>
#include <vector>

namespace palpate::tools {

struct VerifyOptions {
  std::vector<std::string> cases;  // names; empty: all
  bool quick = false;              // coarse rows only
  std::string json;                // file for the results, or ""
  std::string report;              // folder for the page with tables and pictures, or ""
  int threads = 0;                 // 0: one per core
};

/// Runs verification cases and prints their tables and bounds.
/// @return 0 when every bound holds, else 1
/// Throws InputError for an unknown case, std::runtime_error where a file can't be written.
int verifyCommand(const VerifyOptions& options);

}  // namespace palpate::tools

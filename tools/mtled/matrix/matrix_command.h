#pragma once

#include <string>

namespace palpate::tools {

struct MatrixOptions {
  int first = 1, count = 300;  // seeds
  bool make = false;           // only compute the references that are missing, and keep them
  bool quick = false;          // only those with a closed form
  std::string json;            // file for the results, or ""
  std::string report;          // folder for the page, or ""
  int threads = 0;             // 0: one per core; each case has one
};

/// Small scenes drawn by lot beside closed forms and what finer clouds converge to: how far off is what is trusted, and
/// is the error that is expected the true one? References of finer clouds are kept in tests/reference/matrix.csv; those
/// of other seeds are computed (some ten seconds each).
/// @return 3 where a trusted number is off by more than a tenth and what is not known of its reference, else 0
/// Throws std::runtime_error where it was interrupted, or a file can't be written.
int matrixCommand(const MatrixOptions& options);

}  // namespace palpate::tools

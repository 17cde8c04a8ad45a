#pragma once

#include <string>

namespace palpate::tools {

struct MatrixOptions {
  int first = 1, count = 300;  // seeds
  bool make = false;           // compute the references anew and keep them
  std::string json;            // file for all rows, or ""
  int threads = 0;             // 0: one per core; each case has one
};

/// Small scenes drawn by lot beside what finer clouds converge to: how far off is what is trusted, and is the error
/// that is expected the true one? References are kept in tests/reference/matrix.csv; those of other seeds are computed (some
/// seconds each).
/// @return 1 where a trusted number is off by more than a tenth and what is not known of its reference, else 0
/// Throws std::runtime_error where it was interrupted, or a file can't be written.
int matrixCommand(const MatrixOptions& options);

}  // namespace palpate::tools

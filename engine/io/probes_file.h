#pragma once

#include <string>
#include <vector>

#include "base/types.h"
#include "io/csv_table.h"

namespace palpate {

/// Points at which a solution is wanted.
struct Probes {
  std::vector<Vec3> X;  // m, at rest (probe_count)
  CsvTable table;       // all of the file, such as the columns ux, uy, uz of a reference; row i belongs to X[i]
};

/// Reads a CSV file with the columns X, Y, Z (in m; or x, y, z) among others. Throws InputError with file:line
/// where one is missing, a coordinate is no number, or there are no points; at `asked_from` (where
/// another file names this one) where the file can't be read.
Probes readProbes(const std::string& path, const SourceLocation& asked_from = {});

}  // namespace palpate

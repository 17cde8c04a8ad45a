#pragma once

#include <string>
#include <vector>

namespace palpate {

/// A row of a measured force curve: how deep the tool was, m, what it was pushed with, N, and when, s (0: not told).
struct ForceRow {
  double depth = 0, force = 0, time = 0;
};

/// Reads a CSV file (readCsvTable) with columns depth_m or depth_mm and force_N, force_mN or the three of force.csv's
/// raw force, perhaps time_s; or two columns without a header, mm and N. A push counts as positive, whatever the file's
/// sign. Throws InputError with file and line, where a row lacks a number too.
/// @param advance  a column advance_m goes before the depth's
std::vector<ForceRow> readForceRows(const std::string& path, bool advance);

}  // namespace palpate

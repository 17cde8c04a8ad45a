#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpate::app {

/// Whose score sheet a file is, "" where that has no name; nothing where it is none.
std::optional<std::string> traineeOf(const std::string& file);

/// The score sheets of a class as one table.
struct ClassScores {
  std::string csv;                    // a row for each sheet, by the names of their files
  int sheets = 0;                     // rows
  std::vector<std::string> problems;  // files that should be sheets and can't be read, and why
};

/// Reads the JSON of all score sheets below a folder, and leaves other files alone. Numbers stand as in the sheets;
/// what a sheet does not say is left empty. Throws InputError where there is no such folder.
ClassScores classScores(const std::string& folder);

/// `palpate --scores`: writes DIR/scores.csv, or that of `out`. Returns the exit code: 1 where a sheet was unusable.
int writeClassScores(const std::string& folder, const std::string& out);

}  // namespace palpate::app

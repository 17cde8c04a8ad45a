#pragma once

#include <cstddef>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace palpate {

/// A CSV file that grows row by row while something is computed; what is there stays if the program is killed.
/// Numbers are the shortest that read back exactly. Each function throws std::runtime_error with the file
/// and the system's reason when it can't be written.
class ResultCsv {
 public:
  /// Replaces the file and writes the header.
  /// @param columns  names, with units ("time_s"), without commas, quotes and line ends
  ResultCsv(const std::string& path, const std::vector<std::string>& columns);

  /// Adds a row and hands it to the system.
  /// @pre  one value per column
  void add(std::span<const double> values);

  /// Closes the file. Only after this are all rows known to have been taken.
  void finish();

 private:
  void write(const std::string& line);

  std::string path_;
  std::size_t column_count_;
  std::ofstream out_;
};

}  // namespace palpate

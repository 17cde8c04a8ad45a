#pragma once

#include <cstddef>
#include <fstream>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "io/output_file.h"

namespace palpate {

/// A CSV file that grows row by row while something is computed; what is there stays if the program is killed.
/// Numbers are the shortest that read back exactly. Each function throws std::runtime_error with the file
/// and the system's reason when it can't be written.
class ResultCsv {
 public:
  /// Begins beside the file, which stays as it is until takePlace() or finish(), and writes the header.
  /// @param columns  names, with units ("time_s"), without commas, quotes and line ends
  ResultCsv(const std::string& path, const std::vector<std::string>& columns);

  /// Adds a row and hands it to the system.
  /// @param trust  of the last column, where it is one of words: then one value less
  /// @pre  one value per column
  void add(std::span<const double> values, std::string_view trust = {});

  /// Replaces the file with the rows that there are; more may follow.
  void takePlace() { file_.takePlace(); }

  /// Closes the file, which then stands in its place. Only after this are all rows known to have been taken.
  void finish();

 private:
  void write(const std::string& line);

  std::string path_;
  PendingFile file_;
  std::size_t column_count_;
  std::ofstream out_;
};

/// A text as a field: in quotes, its own doubled.
std::string csvQuoted(std::string_view text);

/// A field of a CSV file: text as csvQuoted has it.
template <class Value>
std::ostream& putCsv(std::ostream& out, const Value& value) {
  if constexpr (std::is_convertible_v<Value, std::string_view>)
    return out << csvQuoted(value);
  else
    return out << value;
}

}  // namespace palpate

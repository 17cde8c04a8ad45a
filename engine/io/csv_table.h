#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "base/input_error.h"

namespace palpate {

/// A table of numbers with named columns, from a CSV file.
struct CsvTable {
  std::string file;
  SourceLocation header;                    // the line of the names
  std::vector<std::string> name;            // (column_count), unlike each other
  std::vector<std::vector<double>> column;  // (column_count)(row_count); NaN where the file has none
  std::vector<int> line;                    // (row_count), of the file
  std::vector<std::string> trust;  // (row_count) words of a column of this name, whose numbers are NaN; or empty

  std::size_t rowCount() const { return line.size(); }

  /// The column's index: the name spelt exactly so, else with other capitals, else -1.
  int find(const std::string& wanted) const;

  /// The column. Throws InputError at the header where it is missing.
  const std::vector<double>& operator[](const std::string& wanted) const;
};

/// Reads a CSV file: a line of names, then lines of as many numbers, all separated by commas; or by semicolons or tabs,
/// where the names are; between semicolons numbers may have a decimal comma. Names may stand in double quotes. An empty
/// field and `nan` are NaN; empty lines and lines that begin with # are passed over.
/// @param needed  other columns are not read, but NaN; without it all are needed
/// @param unnamed  of a file whose first line begins with a number: the names of its columns
/// Throws InputError with file:line:column for anything else, and at `asked_from` (where another file
/// names this one) where the file can't be read.
CsvTable readCsvTable(const std::string& path, const SourceLocation& asked_from = {},
                      const std::function<bool(const std::string& name)>& needed = {},
                      const std::vector<std::string>& unnamed = {});

}  // namespace palpate

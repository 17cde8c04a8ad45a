#pragma once

#include <stdexcept>
#include <string>

#include "base/printable_text.h"  // inQuotes

namespace palpate {

/// Where something stands in an input file. Line and column start at 1; 0 means "not known".
struct SourceLocation {
  std::string file;
  int line = 0;
  int column = 0;

  /// "file:line:column", leaving out what is not known.
  std::string text() const {
    std::string s = file;
    if (line > 0) s.append(":").append(std::to_string(line));
    if (line > 0 && column > 0) s.append(":").append(std::to_string(column));
    return s;
  }
};

/// The user's input can't be used. what() reads "place: what is wrong; what to do".
/// Thrown only while loading; the programs print it and exit with code 2.
class InputError : public std::runtime_error {
 public:
  InputError(const SourceLocation& place, const std::string& problem, const std::string& advice)
      : std::runtime_error((place.text().empty() ? "" : place.text() + ": ") + problem +
                           (advice.empty() ? "" : "; " + advice)) {}
};

}  // namespace palpate

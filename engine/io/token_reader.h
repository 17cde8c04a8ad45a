#pragma once

#include <string>
#include <string_view>

#include "base/input_error.h"

namespace palpate {

/// Splits a text into words, keeping count of lines (LF, CR LF or CR) and columns.
class TokenReader {
 public:
  TokenReader(std::string_view text, std::string file) : text_(text), file_(std::move(file)) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = line_start_ = 3;  // a byte-order mark
  }

  /// The next word on this line; empty at the line's end. A `\` at its end continues the line.
  std::string_view nextInLine();

  /// Goes to the start of the next line; false at the end of the text.
  bool nextLine();

  /// The next word, on this line or a later one; empty at the end of the text.
  std::string_view next();

  /// Where the last word stands (at a line's end: the place behind its last word).
  SourceLocation place() const { return {file_, line_of_word_, column_of_word_}; }
  int line() const { return line_; }

 private:
  void markWord();
  void passLineEnd();

  std::string_view text_;
  std::string file_;
  std::size_t at_ = 0, line_start_ = 0;
  int line_ = 1;
  int line_of_word_ = 1, column_of_word_ = 1;
};

/// The word as a finite number. Throws InputError at `place`; `what` names it ("a coordinate").
double parseNumber(std::string_view word, const SourceLocation& place, const std::string& what);

}  // namespace palpate

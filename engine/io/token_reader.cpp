#include "io/token_reader.h"

#include <charconv>
#include <cmath>
#include <system_error>

namespace palpate {

namespace {

bool isLineEnd(char c) { return c == '\n' || c == '\r'; }
bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

}  // namespace

void TokenReader::markWord() {
  line_of_word_ = line_;
  column_of_word_ = static_cast<int>(at_ - line_start_) + 1;
}

void TokenReader::passLineEnd() {
  at_ += text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n' ? 2 : 1;
  line_start_ = at_;
  ++line_;
}

std::string_view TokenReader::nextInLine() {
  for (;;) {
    while (at_ < text_.size() && isBlank(text_[at_])) ++at_;
    const bool continued = at_ + 1 < text_.size() && text_[at_] == '\\' && isLineEnd(text_[at_ + 1]);
    if (!continued) break;
    ++at_;
    passLineEnd();
  }
  markWord();
  const std::size_t begin = at_;
  while (at_ < text_.size() && !isBlank(text_[at_]) && !isLineEnd(text_[at_])) {
    if (text_[at_] == '\\' && at_ + 1 < text_.size() && isLineEnd(text_[at_ + 1])) break;
    ++at_;
  }
  return text_.substr(begin, at_ - begin);
}

bool TokenReader::nextLine() {
  while (at_ < text_.size() && !isLineEnd(text_[at_])) ++at_;
  if (at_ >= text_.size()) return false;
  passLineEnd();
  return true;
}

std::string_view TokenReader::next() {
  for (;;) {
    const std::string_view word = nextInLine();
    if (!word.empty() || !nextLine()) return word;
  }
}

double parseNumber(std::string_view word, const SourceLocation& place, const std::string& what) {
  if (word.empty()) throw InputError(place, what + " is missing", "the line or file may have been cut short");
  std::string_view digits = word;
  if (digits.front() == '+') digits.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error == std::errc::result_out_of_range) {
    throw InputError(place, inQuotes(word) + " is beyond what a number can hold", "check the file's units");
  }
  if (error != std::errc{} || end != digits.data() + digits.size()) {
    const bool comma = word.find(',') != std::string_view::npos;
    throw InputError(place, inQuotes(word) + " is not a number",
                     "write " + what + " like 0.125 or 1.25e-1" + (comma ? ", with a point and not a comma" : ""));
  }
  if (!std::isfinite(value)) {
    throw InputError(place, what + " is " + inQuotes(word) + ", not finite", "repair or export the file again");
  }
  return value;
}

}  // namespace palpate

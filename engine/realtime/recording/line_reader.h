#pragma once

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "base/input_error.h"

namespace palpate {

/// Reads the words of one line of a recording; every error names the line and says to record again.
class LineReader {
 public:
  LineReader(const std::string& file, int number, std::string_view line) : file_(file), number_(number), line_(line) {}

  [[noreturn]] void fail(const std::string& problem, const std::string& advice = "record the run again") const {
    throw InputError({file_, number_, static_cast<int>(word_begin_) + 1}, problem, advice);
  }

  bool atEnd() {
    while (next_ < line_.size() && (line_[next_] == ' ' || line_[next_] == '\t' || line_[next_] == '\r')) ++next_;
    return next_ == line_.size();
  }

  std::string_view word(const char* what) {
    const bool end = atEnd();
    word_begin_ = next_;
    if (end) fail(std::string("the line ends before ") + what);
    while (next_ < line_.size() && line_[next_] != ' ' && line_[next_] != '\t' && line_[next_] != '\r') ++next_;
    return line_.substr(word_begin_, next_ - word_begin_);
  }

  std::string rest(const char* what) {
    word(what);
    std::string_view text = line_.substr(word_begin_);
    while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.remove_suffix(1);
    next_ = line_.size();
    return std::string(text);
  }

  double number(const char* what) {
    const std::string_view text = word(what);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fail(inQuotes(text) + " is not " + what);
    }
    return value;
  }

  std::size_t wordLength() const { return next_ - word_begin_; }

  template <class Integer>
  Integer integer(const char* what, int base = 10) {
    const std::string_view text = word(what);
    Integer value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc() || end != text.data() + text.size()) fail(inQuotes(text) + " is not " + what);
    return value;
  }

  Vec3 vector(const char* what) {
    const double x = number(what), y = number(what), z = number(what);
    return {x, y, z};
  }

  void expect(const char* word_wanted) {
    const std::string_view text = word(word_wanted);
    if (text != word_wanted) fail(inQuotes(text) + " stands where " + inQuotes(word_wanted) + " should");
  }

  void done() {
    if (atEnd()) return;
    word_begin_ = next_;
    fail("the line goes on after its end");
  }

 private:
  const std::string& file_;
  int number_;
  std::string_view line_;
  std::size_t next_ = 0, word_begin_ = 0;
};

}  // namespace palpate

#include "io/toml_depth.h"

#include <algorithm>

#include "base/input_error.h"
#include "io/toml_table.h"

namespace palpate {

namespace {

/// The length of the string at the text's begin, quotes included. One that is not closed on its line ends with the
/// line, one of three quotes with the text: the parser refuses both there.
std::size_t stringLength(std::string_view text) {
  const char quote = text.front();
  const bool escapes = quote == '"';
  const std::string three(3, quote);
  const bool multiline = text.starts_with(three);
  for (std::size_t at = multiline ? 3 : 1; at < text.size(); ++at) {
    if (escapes && text[at] == '\\') {
      // A line end ends a one-line string even behind a backslash.
      if (multiline || (at + 1 < text.size() && text[at + 1] != '\n')) ++at;
    } else if (multiline) {
      if (text.substr(at, 3) != three) continue;
      at += 3;
      for (int k = 0; k < 2 && at < text.size() && text[at] == quote; ++k) ++at;  // quotes that belong to the text
      return at;
    } else if (text[at] == quote) {
      return at + 1;
    } else if (text[at] == '\n') {
      return at;
    }
  }
  return text.size();
}

}  // namespace

void checkTomlDepth(std::string_view text, const std::string& file) {
  int line = 1, dots = 0, brackets = 0;
  std::size_t line_start = 0;
  const auto refuse = [&](std::size_t at, const std::string& problem, const std::string& advice) {
    throw InputError({file, line, static_cast<int>(at - line_start) + 1}, problem, advice);
  };
  const std::string limit = std::to_string(max_toml_depth);
  for (std::size_t at = 0; at < text.size();) {
    std::size_t length = 1;
    switch (text[at]) {
      case '"':
      case '\'':
        length = stringLength(text.substr(at));
        break;
      case '#':
        length = std::min(text.find('\n', at), text.size()) - at;
        break;
      case '.':
        if (++dots >= max_toml_depth) refuse(at, "a key of more than " + limit + " parts", "no key has so many");
        break;
      case '[':
      case '{':
        dots = 0;
        if (++brackets > max_toml_depth)
          refuse(at, "more than " + limit + " lists or tables within one another", "no key needs so many");
        break;
      case ']':
      case '}':
        brackets = std::max(0, brackets - 1);
        [[fallthrough]];
      case ',':
      case '=':
      case '\n':
        dots = 0;
        break;
      default:
        break;
    }
    for (const std::size_t end = at + length; at < end; ++at) {
      if (text[at] != '\n') continue;
      ++line;
      line_start = at + 1;
    }
  }
}

}  // namespace palpate

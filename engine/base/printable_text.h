#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpate {

enum class LineEnds { Replace, Keep };

/// The text as a terminal, a report in JSON and one line of a recording can hold it: valid UTF-8 without control
/// characters (U+0000 .. U+001F, U+007F .. U+009F). Each of those and each byte that is no UTF-8 becomes a '?'.
/// @param line_ends  whether '\n' stays, as in a message of several lines
std::string printable(std::string_view text, LineEnds line_ends = LineEnds::Replace);

/// The text's begin, of at most so many bytes; a character of UTF-8 is not cut in two.
std::string_view cutText(std::string_view text, std::size_t most);

/// What a message quotes from an input file: in quotes, shortened, unprintable characters replaced.
std::string inQuotes(std::string_view word);

/// The text with small letters for A to Z.
std::string lowerCase(std::string_view text);

}  // namespace palpate

#pragma once

#include <charconv>
#include <cstdint>
#include <string>

namespace palpate {

/// printf into a string of any length.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

/// A count as "%lld" takes it.
inline long long asLongLong(std::int64_t count) { return count; }

/// The shortest decimal text that reads back as the same bits.
inline std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// 16 hex digits, as hashes are written.
inline std::string hex16(std::uint64_t value) {
  char text[16];
  const std::string digits(text, std::to_chars(text, text + sizeof text, value, 16).ptr);
  return std::string(16 - digits.size(), '0') + digits;
}

}  // namespace palpate

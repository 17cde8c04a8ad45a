#pragma once

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace palpate {

/// All bytes of a file; none where it can't be opened.
inline std::string readAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// The text with the first `what`, which must be there, replaced.
inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("nothing to replace: " + what);
  return text.replace(at, what.size(), with);
}

}  // namespace palpate

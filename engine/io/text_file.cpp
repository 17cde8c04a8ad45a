#include "io/text_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace palpate {

std::string readWholeFile(const std::string& path, const SourceLocation& asked_from) {
  const bool named_elsewhere = !asked_from.file.empty();
  const SourceLocation place = named_elsewhere ? asked_from : SourceLocation{path, 0, 0};
  const std::string which = named_elsewhere ? "the file " + path : std::string("the file");
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw InputError(place, which + " does not exist",
                     "check its name; relative paths in a file start from its folder");
  }
  if (std::filesystem::is_directory(status)) {
    throw InputError(place, (named_elsewhere ? path : std::string("this")) + " is a folder", "name a file in it");
  }
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in.is_open() || in.bad()) throw InputError(place, which + " can't be read", "check its permissions");
  return bytes;
}

}  // namespace palpate

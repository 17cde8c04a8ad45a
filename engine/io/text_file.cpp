#include "io/text_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace palpate {

std::string readWholeFile(const std::string& path, const SourceLocation& asked_from, std::uintmax_t max_bytes) {
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
  if (!std::filesystem::is_regular_file(status)) {
    throw InputError(place, which + " is a device or a pipe, which need not end", "name a file on a disk");
  }
  const auto refuseLength = [&] {
    throw InputError(place, which + " is longer than the " + std::to_string(max_bytes) + " bytes that are read",
                     "check that it is the right file");
  };
  const std::uintmax_t stated = std::filesystem::file_size(path, error);
  if (!error && stated > max_bytes) refuseLength();

  std::ifstream in(path, std::ios::binary);
  std::string bytes;
  // In one block, unless it grows while it is read, or states no length, as the files of /proc do.
  std::size_t block = std::max<std::size_t>(error ? 0 : stated + 1, 1 << 16);
  while (in && bytes.size() <= max_bytes) {
    const std::size_t before = bytes.size();
    bytes.resize(before + block);
    in.read(bytes.data() + before, static_cast<std::streamsize>(block));
    bytes.resize(before + static_cast<std::size_t>(in.gcount()));
    block = std::max<std::size_t>(bytes.size() / 2, 1 << 16);
  }
  if (!in.is_open() || in.bad()) throw InputError(place, which + " can't be read", "check its permissions");
  if (bytes.size() > max_bytes) refuseLength();
  return bytes;
}

}  // namespace palpate

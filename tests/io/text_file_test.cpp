#include "io/text_file.h"

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "support/temp_folder.h"

using namespace palpate;
using Catch::Contains;

TEST_CASE("A file is read whole, whatever bytes it has", "[io][text_file]") {
  TempFolder folder;
  std::string bytes(300'000, '\0');
  for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = static_cast<char>(k * k % 251);
  for (const std::size_t length : {0, 1, 65535, 65536, 65537, 300'000}) {
    CHECK(readWholeFile(folder.write("a", bytes.substr(0, length))) == bytes.substr(0, length));
  }
  CHECK(readWholeFile("/proc/self/status").starts_with("Name:"));  // a file that states no length
}

TEST_CASE("What need not end is refused before it is opened", "[io][text_file][refusal]") {
  TempFolder folder;
  CHECK_THAT(refusal([&] { readWholeFile("/dev/zero"); }), Contains("/dev/zero: the file is a device or a pipe"));
  CHECK_THAT(refusal([&] {
               readWholeFile("/dev/zero", {"a.toml", 3, 11});
             }),
             Contains("a.toml:3:11: the file /dev/zero is a device or a pipe"));
  const std::string pipe = folder.path("pipe");
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK_THAT(refusal([&] { readWholeFile(pipe); }), Contains("pipe: the file is a device or a pipe"));
  CHECK_THAT(refusal([&] { readWholeFile(folder.path("")); }), Contains("this is a folder"));
}

TEST_CASE("A file longer than what is read is refused", "[io][text_file][refusal]") {
  TempFolder folder;
  const std::string ten = folder.write("ten", "0123456789");
  CHECK(readWholeFile(ten, {}, 10) == "0123456789");
  CHECK_THAT(refusal([&] { readWholeFile(ten, {}, 9); }), Contains("ten: the file is longer than the 9 bytes"));
  // One that states no length is found to be too long while it is read.
  CHECK_THAT(refusal([&] { readWholeFile("/proc/self/status", {}, 9); }), Contains("longer than the 9 bytes"));
  std::filesystem::resize_file(ten, std::uintmax_t{1} << 40);  // a hole on the disk
  CHECK_THAT(refusal([&] { readWholeFile(ten); }), Contains("longer than the 1073741824 bytes"));
}

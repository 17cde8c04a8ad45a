#include "app/render/picture.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "app/render/picture_difference.h"
#include "base/input_error.h"
#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// A red disc on a grey gradient, its centre moved and its brightness changed as asked.
Picture disc(double centre_x, int brighter = 0, int noise = 0) {
  Picture p{160, 120, {}};
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const bool inside = std::hypot(x - centre_x, y - 60.0) < 35;
      const int jitter = noise * ((x * 7 + y * 13) % 3 - 1);
      const auto value = [&](int c) { return static_cast<std::uint8_t>(std::clamp(c + brighter + jitter, 0, 255)); };
      for (const int c : {inside ? 180 : 60 + y / 2, inside ? 60 : 60 + y / 2, inside ? 50 : 65 + y / 2})
        p.rgb.push_back(value(c));
    }
  return p;
}

std::string scratch(const char* name) {
  return std::filesystem::temp_directory_path() / (std::to_string(::getpid()) + name);
}

}  // namespace

TEST_CASE("A PNG brings back every byte", "[picture]") {
  const std::string file = scratch("palpate_picture_test.png");
  const Picture written = disc(80);
  writePng(file, written);
  const Picture read = readPng(file);
  CHECK(read.width == written.width);
  CHECK(read.height == written.height);
  CHECK(read.rgb == written.rgb);
  std::filesystem::remove(file);
}

TEST_CASE("A file that is no PNG is refused with its name", "[picture]") {
  const std::string file = scratch("palpate_not_a_picture.png");
  std::ofstream(file) << "no picture";
  CHECK_THROWS_WITH(readPng(file), Catch::Contains(file));
  CHECK_THROWS_AS(readPng(file), InputError);
  CHECK_THROWS_AS(readPng("/does/not/exist.png"), InputError);
  CHECK_THROWS_WITH(writePng("/does/not/exist/x.png", disc(80)), Catch::Contains("/does/not/exist/x.png"));
  std::filesystem::remove(file);
}

TEST_CASE("A picture that does not fit on the disk is an error with file, reason and advice", "[picture]") {
  const TempFolder folder;
  const std::string file = folder.write("snapshot.png", "the one before");
  std::filesystem::create_symlink("/dev/full", file + ".part");
  CHECK_THROWS_WITH(writePng(file, disc(80)),
                    Catch::Contains("can't write " + file + ": No space left on device; free some space"));
  CHECK(readAll(file) == "the one before");
}

TEST_CASE("Rounding, dither and a contour's neighbouring pixel don't make another picture", "[picture]") {
  const PictureDifference itself = difference(disc(80), disc(80));
  CHECK(itself.mean == 0);
  CHECK(itself.worst == 0);
  CHECK(looksSame(itself));
  CHECK(looksSame(difference(disc(80), disc(80, 1))));
  CHECK(looksSame(difference(disc(80), disc(80, 0, 1))));
}

TEST_CASE("Different pictures are different", "[picture]") {
  CHECK_FALSE(looksSame(difference(disc(80), disc(82))));     // moved by two pixels
  CHECK_FALSE(looksSame(difference(disc(80), disc(80, 6))));  // a little brighter all over
  CHECK_FALSE(looksSame(difference(disc(80), disc(500))));    // disc missing
  Picture hue = disc(80);
  for (std::size_t i = 0; i < hue.rgb.size(); i += 3) std::swap(hue.rgb[i], hue.rgb[i + 1]);
  CHECK_FALSE(looksSame(difference(disc(80), hue)));  // as light, but green
}

TEST_CASE("The difference picture marks what differs, and only that", "[picture]") {
  const PictureDifference d = difference(disc(80), disc(90));
  const auto brightness = [&](int x, int y) { return d.image.rgb[3 * (y * d.image.width + x)]; };
  CHECK(brightness(120, 60) > 200);  // where the disc arrived
  CHECK(brightness(80, 60) < 60);    // inside both
  CHECK(brightness(10, 10) < 60);    // outside both
}

TEST_CASE("Pictures of different sizes can't be compared", "[picture]") {
  Picture small{2, 1, std::vector<std::uint8_t>(6)};
  CHECK_THROWS_WITH(difference(disc(80), small), Catch::Contains("160x120") && Catch::Contains("2x1"));
}

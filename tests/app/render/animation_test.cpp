#include "app/render/animation.h"

#include <catch2/catch.hpp>

#include <cstdint>
#include <stdexcept>

#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// A dark ground with a light square at x.
Picture squareAt(int x) {
  Picture picture{64, 40, std::vector<std::uint8_t>(64 * 40 * 3, 20)};
  for (int b = 10; b < 20; ++b)
    for (int a = x; a < x + 10; ++a)
      for (int c = 0; c < 3; ++c) picture.rgb[static_cast<std::size_t>(3 * (64 * b + a) + c)] = 220;
  return picture;
}

std::uint32_t bigEndian(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < 4; ++k) value = value << 8 | static_cast<std::uint8_t>(bytes[at + k]);
  return value;
}

}  // namespace

TEST_CASE("An animation is a PNG of its first picture, with what changes after it", "[animation]") {
  const TempFolder folder;
  const std::string file = folder.path("a.png");
  writeAnimation(file, {squareAt(5), squareAt(15), squareAt(15), squareAt(25)}, 0.1, 2);
  const Picture first = readPng(file);
  const Picture wanted = squareAt(5);
  REQUIRE(first.rgb.size() == wanted.rgb.size());
  CHECK(first.rgb == wanted.rgb);  // few colours: none is changed

  // The chunks: length, name, data, sum.
  const std::string bytes = readAll(file);
  std::string names;
  std::vector<std::uint32_t> widths;
  std::uint32_t sequence = 0;
  for (std::size_t at = 8; at < bytes.size(); at += 12 + bigEndian(bytes, at)) {
    const std::string name = bytes.substr(at + 4, 4);
    names += name + " ";
    if (name == "fcTL") widths.push_back(bigEndian(bytes, at + 12));
    if (name == "fcTL" || name == "fdAT") CHECK(bigEndian(bytes, at + 8) == sequence++);
    if (name == "acTL") CHECK(bigEndian(bytes, at + 8) == 4);
  }
  CHECK(names == "IHDR acTL PLTE tRNS fcTL IDAT fcTL fdAT fcTL fdAT fcTL fdAT IEND ");
  CHECK(widths == std::vector<std::uint32_t>{64, 20, 1, 20});  // the whole, the square's way, nothing, its way
}

TEST_CASE("An animation of nothing, or of unequal sizes, is refused", "[animation]") {
  CHECK_THROWS_AS(writeAnimation("x.png", {}, 0.1, 1), std::invalid_argument);
  Picture small = squareAt(5);
  small.height = 20;
  CHECK_THROWS_AS(writeAnimation("x.png", {squareAt(5), small}, 0.1, 1), std::invalid_argument);
}

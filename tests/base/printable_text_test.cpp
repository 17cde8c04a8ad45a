#include "base/printable_text.h"

#include <catch2/catch.hpp>

using namespace palpate;

TEST_CASE("Text that can be printed stays as it is", "[printable_text]") {
  // 1 to 4 bytes, first and last of each length but for control characters
  for (const char* text : {"", "Liver, 3.4 mm", "\xc2\xa0", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xef\xbf\xbd", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"}) {
    CHECK(printable(text) == text);
  }
}

TEST_CASE("Control characters and bytes that are no UTF-8 become question marks", "[printable_text]") {
  CHECK(printable("a\nb\tc\x1b[2J\x7f") == "a?b?c?[2J?");
  CHECK(printable(std::string_view("a\0b", 3)) == "a?b");
  CHECK(printable("\xc2\x80\xc2\x9f") == "??");                        // U+0080, U+009F: control characters, too
  CHECK(printable("\x80\xbf\xff\xfe") == "????");                      // no first bytes
  CHECK(printable("\xc0\x8a\xe0\x8a\x8a") == "?????");                 // line ends in longer forms than needed
  CHECK(printable("\xed\xa0\x80") == "???");                           // half of a UTF-16 pair
  CHECK(printable("\xf4\x90\x80\x80\xf5\x80\x80\x80") == "????????");  // beyond U+10FFFF
  CHECK(printable("\xe2\x82") == "??");                                // cut off
  CHECK(printable("\xe2\x82z\xf0\x90\x80") == "??z???");
}

TEST_CASE("Line ends stay where they are wanted", "[printable_text]") {
  CHECK(printable("a\nb\r\n", LineEnds::Keep) == "a\nb?\n");
}

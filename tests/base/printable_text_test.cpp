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

TEST_CASE("A text is cut between its characters", "[printable_text]") {
  CHECK(cutText("abc", 3) == "abc");
  CHECK(cutText("abcd", 3) == "abc");
  const std::string umlaut = "y\xc3\xb6ung";
  CHECK(cutText(umlaut, 3) == "y\xc3\xb6");
  CHECK(cutText(umlaut, 2) == "y");
  CHECK(cutText("a\xf0\x90\x80\x80", 4) == "a");
  CHECK(cutText("\x80\x80\x80\x80\x80\x80", 5).size() >= 2);  // no UTF-8
}

TEST_CASE("What a message quotes keeps its letters, and loses what a terminal obeys", "[printable_text]") {
  CHECK(inQuotes("y\xc3\xb6ung") == "\"y\xc3\xb6ung\"");
  CHECK(inQuotes("a\x1b[2J\n") == "\"a?[2J?\"");
  const std::string many(39, 'x');
  CHECK(inQuotes(many + "\xc3\xb6") == "\"" + many + "...\"");
  CHECK(inQuotes(many + "xx") == "\"" + many + "x...\"");
}

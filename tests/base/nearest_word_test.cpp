#include "base/nearest_word.h"

#include <catch2/catch.hpp>

using namespace palpate;

TEST_CASE("The nearest word is what a slip of the fingers meant", "[nearest_word]") {
  const std::vector<std::string> known = {"young", "poisson", "density", "mu"};
  CHECK(nearestWord("yuong", known) == "young");  // neighbours swapped
  CHECK(nearestWord("yung", known) == "young");   // one left out
  CHECK(nearestWord("dennsity", known) == "density");
  CHECK(nearestWord("poissen", known) == "poisson");
  CHECK(nearestWord("um", known) == "mu");
  CHECK(nearestWord("yougn", {}).empty());
  CHECK(nearestWord("guony", known).empty());  // three letters elsewhere: a guess would mislead
}

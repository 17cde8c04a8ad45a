#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "support/temp_folder.h"
#include "support/text.h"

namespace palpate {

/// What makes a good text a bad one, and what is to be said of it.
struct BadText {
  const char *what, *with;  // in its stead
  std::string place;        // after the file's name; its last number is whole
  const char *problem, *advice;
};

/// Checks that `read(path)` refuses each at its place, with advice.
template <class Read>
void checkRefused(const TempFolder& folder, const std::string& file, const std::string& good,
                  const std::vector<BadText>& bad, Read&& read) {
  for (const BadText& b : bad) {
    INFO(b.what << " -> " << b.with);
    const std::string path = folder.write(file, replaced(good, b.what, b.with));
    const std::string message = refusal([&] { read(path); });
    INFO(message);
    CHECK_THAT(message, Catch::Contains(path + b.place + (b.place.back() == ':' ? "" : ":")));
    CHECK_THAT(message, Catch::Contains(b.problem));
    CHECK_THAT(message, Catch::Contains(b.advice));
  }
}

}  // namespace palpate

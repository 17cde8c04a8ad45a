#include "io/result_csv.h"

#include <catch2/catch.hpp>
#include <filesystem>

#include "support/temp_folder.h"
#include "support/text.h"

using namespace palpate;

TEST_CASE("A table that is given up leaves what stood there - one that takes its place grows there", "[io][output]") {
  const TempFolder folder;
  const std::string path = folder.write("force.csv", "earlier\n");
  {
    ResultCsv csv(path, {"a", "b"});
    csv.add(std::vector<double>{1, 2});
    CHECK(readAll(path) == "earlier\n");
  }
  CHECK(readAll(path) == "earlier\n");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
  {
    ResultCsv csv(path, {"a", "b"});
    csv.add(std::vector<double>{1, 2});
    csv.takePlace();
    CHECK(readAll(path) == "a,b\n1,2\n");
    csv.add(std::vector<double>{3, 4});
    CHECK(readAll(path) == "a,b\n1,2\n3,4\n");
  }  // killed, as it were: the rows stay
  CHECK(readAll(path) == "a,b\n1,2\n3,4\n");
  ResultCsv csv(path, {"c"});
  csv.finish();
  CHECK(readAll(path) == "c\n");
  CHECK_FALSE(std::filesystem::exists(path + ".part"));
}

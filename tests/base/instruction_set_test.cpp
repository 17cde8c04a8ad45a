#include "base/instruction_set.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>

#include "base/build_info.h"
#include "base/input_error.h"

using namespace palpate;

namespace {

/// PALPATE_KERNEL for a while.
class Wanted {
 public:
  explicit Wanted(const char* value) {
    if (const char* old = std::getenv(name)) old_ = old;
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~Wanted() { old_.empty() ? unsetenv(name) : setenv(name, old_.c_str(), 1); }
  Wanted(const Wanted&) = delete;
  Wanted& operator=(const Wanted&) = delete;

 private:
  static constexpr const char* name = "PALPATE_KERNEL";
  std::string old_;
};

}  // namespace

TEST_CASE("The widest instruction set is chosen, or the one that PALPATE_KERNEL names", "[instruction_set]") {
  const auto supported = supportedInstructionSets();
  REQUIRE(supported.front() == InstructionSet::Plain);
  CHECK(std::is_sorted(supported.begin(), supported.end()));
  {
    const Wanted none(nullptr);
    CHECK(chosenInstructionSet() == supported.back());
  }
  for (const InstructionSet set : supported) {
    const Wanted wanted(nameOf(set));
    CHECK(chosenInstructionSet() == set);
    CHECK_THAT(buildInfo(), Catch::Contains(std::string("kernel ") + nameOf(set)));
  }
}

TEST_CASE("A kernel that is unknown or can't run here is refused with the choice there is", "[instruction_set]") {
  const Wanted unknown("sse9");
  CHECK_THROWS_WITH(chosenInstructionSet(),
                    Catch::Contains("\"sse9\" is no kernel") && Catch::Contains("choose from: plain"));
  CHECK_THAT(buildInfo(), Catch::Contains("no kernel"));
  const auto supported = supportedInstructionSets();
  for (const InstructionSet set : {InstructionSet::Avx2, InstructionSet::Avx512}) {
    if (std::count(supported.begin(), supported.end(), set) > 0) continue;
    const Wanted wanted(nameOf(set));
    CHECK_THROWS_WITH(chosenInstructionSet(), Catch::Contains("does not have these instructions"));
  }
}

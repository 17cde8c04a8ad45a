#include <catch2/catch.hpp>
#include <set>

#include "mtled/matrix/matrix_case.h"

using namespace palpate;
using namespace palpate::tools;

TEST_CASE("A case drawn by lot follows from its seed, and the lot draws all kinds", "[matrix]") {
  std::set<std::string> kinds;
  double lowest = 1, highest = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const MatrixCase one = drawCase(seed), again = drawCase(seed);
    REQUIRE(one.kind == again.kind);
    REQUIRE(one.scene.spacing == again.scene.spacing);
    REQUIRE(one.depth == again.depth);
    kinds.insert(one.kind.substr(0, one.kind.find(',')));
    const Material& m = one.scene.materials[0].material;
    const double K = m.bulk_modulus, mu = m.shear_modulus, nu = (3 * K - 2 * mu) / (2 * (3 * K + mu));
    lowest = std::min(lowest, nu);
    highest = std::max(highest, nu);
    CHECK(one.pressed == (one.depth > 0));
  }
  CHECK(kinds == std::set<std::string>{"press sphere", "press cylinder", "press capsule", "press cone", "stretch",
                                       "compress", "shear", "twist"});
  CHECK(lowest >= 0);
  CHECK(lowest < 0.1);
  CHECK(highest > 0.495);
  CHECK(highest < 0.4991);
}

TEST_CASE("A finer cloud has more nodes and answers nearly the same", "[matrix][whole]") {
  unsigned seed = 1;
  while (drawCase(seed).kind != "stretch") ++seed;
  const MatrixCase one = drawCase(seed);
  const MatrixAnswer coarse = answerOf(one, 1, 1), fine = answerOf(one, 0.7, 1);
  REQUIRE(coarse.sound);
  REQUIRE(fine.sound);
  CHECK(fine.nodes > 2 * coarse.nodes);
  CHECK(coarse.value == Approx(fine.value).epsilon(0.05));
}

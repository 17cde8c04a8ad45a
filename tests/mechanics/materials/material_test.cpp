#include <catch2/catch.hpp>

#include "support/kernel_forces.h"
#include "support/law_lanes.h"

using namespace palpate;

TEST_CASE("No crushed or inverted point has less energy than none, and inside out it is pushed back",
          "[material][kernel]") {
  const double mu[] = {400, 250}, alpha[] = {2.5, -3};
  for (const auto& m : {Material::neoHookean(3000, 0.49, 1000), Material::neoHookean(1000, 0.3, 1000), test::ogden(),
                        Material::ogden(mu, alpha, 2, 1e-4, 1000)})
    for (const double J : {0.03, 0.019, 0.01, 0.002, -0.02, -0.3})
      for (const double l : {0.2, 0.5, 1.0}) {
        const Mat3 F = Vec3(1 / l, l, J).asDiagonal();
        CAPTURE(m.lawDescription().name, J, l);
        float lanes = 0;
        const Mat3 P = m.firstPiola(F), of_lanes = test::lanesPiola(m, F, &lanes);
        CHECK(m.energy(F) > 0);
        if (J == -0.3) CHECK(P(2, 2) < 0);  // f = -dW/dF pushes the point back towards J > 0
        CHECK(lanes == Approx(m.energy(F)).epsilon(0.01));
        CHECK((of_lanes - P).norm() <= 0.02 * P.norm());
      }
}

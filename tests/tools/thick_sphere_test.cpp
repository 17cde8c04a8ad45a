#include "mtled/verify/thick_sphere.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace palpate;
using namespace palpate::tools;

TEST_CASE("The thick sphere's pressure is Green and Zerna's where volume is kept, and Lame's where strains are small",
          "[thick_sphere]") {
  Material m = Material::neoHookean(3000, 0.4999, 1000);
  for (const double stretch : {1.1, 1.5, 2.0}) {
    const ThickSphere sphere(m, 0.01, 0.02, stretch);
    const double outer = std::cbrt(1 + (stretch * stretch * stretch - 1) / 8);
    const auto term = [](double l) { return 4 / l + std::pow(l, -4); };
    CHECK(sphere.outerStretch() == Approx(outer).epsilon(2e-4));
    CHECK(sphere.pressure() == Approx(m.shear_modulus / 2 * (term(outer) - term(stretch))).epsilon(1e-3));
  }
  m = Material::neoHookean(3000, 0.3, 1000);
  // u(a) = p a a^3 / (b^3 - a^3) (1 / (3 K) + b^3 / (4 mu a^3))
  const double p = 1e-4 * 7 / (1 / (3 * m.bulk_modulus) + 8 / (4 * m.shear_modulus));
  CHECK(ThickSphere(m, 0.01, 0.02, 1.0001).pressure() == Approx(p).epsilon(2e-3));
}

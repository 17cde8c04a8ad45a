#include "mechanics/materials/mooney_rivlin.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr double c10 = 350, c01 = 150, D1 = 4e-5;  // mu 1000 Pa, K 50 kPa

Material mooneyRivlin(double first = c10, double second = c01) {
  return Material::of("mooney-rivlin").set("c10", first).set("c01", second).set("D1", D1);
}

}  // namespace

TEST_CASE("Mooney-Rivlin: uniaxial, equibiaxial and shear stresses of the closed forms at J = 1", "[material]") {
  const Material m = mooneyRivlin();
  for (double l = 0.4; l < 3.01; l += 0.1) {
    const double t = 1 / std::sqrt(l), thin = 1 / (l * l);
    INFO("stretch " << l);
    const double tolerance = 1e-13 * m.bulk_modulus * (1 + l * l + thin * thin);
    const Mat3 pulled = m.firstPiola(Vec3(t, t, l).asDiagonal());  // Mooney: 2 (c10 + c01 / l) (l^2 - 1 / l)
    CHECK(std::abs(pulled(2, 2) * l - pulled(0, 0) * t - 2 * (c10 + c01 / l) * (l * l - 1 / l)) < tolerance);
    const Mat3 spread = m.firstPiola(Vec3(l, l, thin).asDiagonal());
    const double stress = 2 * (c10 + c01 * l * l) * (l * l - thin * thin);
    CHECK(std::abs(spread(0, 0) * l - spread(2, 2) * thin - stress) < tolerance * (1 + l * l));
  }
  for (double gamma = 0; gamma < 2.01; gamma += 0.1) {
    INFO("shear " << gamma);
    Mat3 F = Mat3::Identity();
    F(0, 1) = gamma;
    const Mat3 cauchy = m.firstPiola(F) * F.transpose();  // 2 c10 dev B - 2 c01 dev B^-1
    const double tolerance = 1e-12 * m.bulk_modulus;
    CHECK(std::abs(cauchy(0, 1) - 2 * (c10 + c01) * gamma) < tolerance);
    CHECK(std::abs(cauchy(0, 0) - cauchy(2, 2) - 2 * c10 * gamma * gamma) < tolerance);
    CHECK(std::abs(cauchy(1, 1) - cauchy(2, 2) + 2 * c01 * gamma * gamma) < tolerance);
  }
}

TEST_CASE("Mooney-Rivlin with c01 = 0 is the neo-Hookean law", "[material]") {
  const Material m = mooneyRivlin(500, 0);
  const double mu = 1000, K = 2 / D1;
  const Material neo = Material::neoHookean(9 * K * mu / (3 * K + mu), (3 * K - 2 * mu) / (2 * (3 * K + mu)), 1000);
  for (const Mat3& F : irregularStates()) {
    const double scale = K * (1 + F.squaredNorm()) * (1 + F.norm());  // of rounding
    CHECK((m.firstPiola(F) - neo.firstPiola(F)).norm() < 1e-13 * scale);
    CHECK(std::abs(m.energy(F) - neo.energy(F)) < 1e-13 * scale * (1 + F.norm()));
  }
  Mat3 F = Mat3::Identity();
  F(0, 1) = 1;
  CHECK((mooneyRivlin().firstPiola(F) - neo.firstPiola(F)).norm() > 0.1 * mu);  // and else it is not
}

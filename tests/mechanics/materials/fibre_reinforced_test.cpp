#include "mechanics/materials/fibre_reinforced.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "mechanics/materials/fibre_energy.h"
#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr double young = 2000, poisson = 0.49, mu = young / (2 * (1 + poisson)), k1 = 3000, k2 = 0.4;

Material fibres(const Vec3& along, double exponent = k2) {
  return Material::of("fibre-reinforced")
      .set("young", young)
      .set("poisson", poisson)
      .set("k1", k1)
      .set("k2", exponent)
      .set("fibre", {along.data(), 3});
}

/// 2 dW/dI4 of the fibres.
double tension(double I4, double exponent = k2) {
  const double e = std::max(I4 - 1, 0.0);
  return 2 * k1 * e * std::exp(exponent * e * e);
}

}  // namespace

TEST_CASE("Fibre-reinforced: stretch along the fibres and across, of the closed forms at J = 1", "[material]") {
  for (const double exponent : {0.0, k2})
    for (double l = 0.4; l < 1.81; l += 0.1) {
      INFO("stretch " << l << ", k2 " << exponent);
      const double t = 1 / std::sqrt(l), rounding = 1e-12 * fibres(Vec3::UnitZ()).bulk_modulus * (1 + l * l + t * t);
      // Along: mu (l^2 - 1 / l) + 2 W' l^2, with fibres that bear tension alone.
      const Mat3 along = fibres(Vec3(0, 0, -7), exponent).firstPiola(Vec3(t, t, l).asDiagonal());
      CHECK(std::abs(along(2, 2) * l - along(0, 0) * t - mu * (l * l - 1 / l) - tension(l * l, exponent) * l * l) <
            rounding);
      CHECK(along(0, 0) == Approx(along(1, 1)).epsilon(1e-12).margin(rounding));
      // Across: a strip stretched to l along z that its fibres along x let get thin in y.
      const double thin = std::pow(l, -0.8), wide = 1 / (l * thin);
      const Mat3 across = fibres(Vec3::UnitX(), exponent).firstPiola(Vec3(wide, thin, l).asDiagonal());
      CHECK(std::abs(across(2, 2) * l - across(1, 1) * thin - mu * (l * l - thin * thin)) < rounding);
      CHECK(std::abs(across(0, 0) * wide - across(1, 1) * thin - mu * (wide * wide - thin * thin) -
                     tension(wide * wide, exponent) * wide * wide) < rounding);
    }
}

TEST_CASE("Fibre-reinforced: simple shear at angles to the fibres, of the closed form", "[material]") {
  for (double angle = 0; angle < 3.1; angle += 0.3)
    for (double gamma = 0; gamma < 1.21; gamma += 0.1) {
      INFO("fibres at " << angle << ", shear " << gamma);
      const double c = std::cos(angle), s = std::sin(angle), x = c + gamma * s;  // F n = (x, s, 0)
      const double T = tension(x * x + s * s);
      Mat3 F = Mat3::Identity();
      F(0, 1) = gamma;
      const Mat3 cauchy = fibres(Vec3(c, s, 0)).firstPiola(F) * F.transpose();
      const double rounding = 1e-12 * fibres(Vec3::UnitZ()).bulk_modulus;
      CHECK(std::abs(cauchy(0, 1) - mu * gamma - T * x * s) < rounding);
      CHECK(std::abs(cauchy(1, 0) - cauchy(0, 1)) < rounding);
      CHECK(std::abs(cauchy(0, 0) - cauchy(2, 2) - mu * gamma * gamma - T * x * x) < rounding);
      CHECK(std::abs(cauchy(1, 1) - cauchy(2, 2) - T * s * s) < rounding);
    }
}

TEST_CASE("Fibre-reinforced: folded fibres and none at all are the matrix, and no stretch is beyond a float",
          "[material]") {
  const Material neo = Material::neoHookean(young, poisson, 1000);
  const Mat3 pressed = Vec3(1.2, 1.1, 0.7).asDiagonal();
  CHECK(fibres(Vec3::UnitZ()).firstPiola(pressed) == neo.firstPiola(pressed));
  CHECK(fibres(Vec3::UnitZ()).energy(pressed) == neo.energy(pressed));
  const Mat3 pulled = Vec3(0.8, 0.9, 1.4).asDiagonal();
  CHECK(fibres(Vec3::UnitZ()).set("k1", 0).firstPiola(pulled) == neo.firstPiola(pulled));
  CHECK((fibres(Vec3::UnitZ()).firstPiola(pulled) - neo.firstPiola(pulled)).norm() > mu);
  // From k2 e^2 = 8 on the tension goes on straight, with neither step nor kink.
  const double last = std::sqrt(8 / 50.0);
  const auto slope = [](double e) { return FibreReinforced::Fibre(fibres(Vec3::UnitZ(), 50), 1 + e).slope; };
  CHECK(slope(last + 1e-6) - slope(last) == Approx(slope(last) - slope(last - 1e-6)).epsilon(1e-3));
  CHECK(slope(20) - slope(10) == Approx(slope(30) - slope(20)).epsilon(1e-9));
  CHECK(slope(1000) * 1000 < 1e15);
}

TEST_CASE("Fibre-reinforced: fibres have a direction", "[material]") {
  const Material lost = fibres(Vec3::Zero());
  REQUIRE(lost.lawDescription().check(lost));
  CHECK(std::string(lost.lawDescription().check(lost)->parameter) == "fibre");
  const Material m = fibres(Vec3(0, 3, 4));
  CHECK_FALSE(m.lawDescription().check(m));
  CHECK(m.fibre[1] == Approx(0.6));
  CHECK(m.fibre[2] == Approx(0.8));
  CHECK(m.fibre_modulus == Approx(4 * k1));
}

TEST_CASE("Fibre-reinforced: the slope of what fibres store is their tension", "[material]") {
  for (const double exponent : {0.0, k2})
    for (const double I4 : {0.8, 1.3, 2.2}) {
      constexpr double h = 1e-5;
      const Material m = fibres(Vec3(0, 3, 4), exponent);
      CHECK((fibreEnergy(m, I4 + h) - fibreEnergy(m, I4 - h)) / h == Approx(tension(I4, exponent)).epsilon(1e-6));
    }
  CHECK(fibreEnergy(Material::neoHookean(young, poisson, 1000), 2) == 0);
}

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "support/law_lanes.h"
#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

// Material::barrier_strength: what keeps points from collapsing, below barrier_J0 only.

namespace {

std::vector<Material> plainMaterials() {
  const double mu[] = {400, 250}, alpha[] = {2.5, -3};
  return {Material::neoHookean(3000, 0.49, 1000), Material::ogden(mu, alpha, 2, 1e-4, 1000)};
}

Material barred(Material m, double strength = 1.5, double J0 = 0.5) {
  m.barrier_strength = strength;
  m.barrier_J0 = J0;
  return m;
}

}  // namespace

TEST_CASE("With the barrier too, stress is the derivative of the energy, inverted states included",
          "[material][barrier]") {
  for (const Material& plain : plainMaterials()) {
    const Material m = barred(plain);
    for (const double J : {0.6, 0.45, 0.2, 0.05, 0.01, -0.1, -0.5}) {
      const Mat3 P = m.firstPiola(withJ(J)), difference = energyDifferences(m, withJ(J), 1e-6);
      for (int k = 0; k < 9; ++k) {
        INFO("J " << J << " component " << k);
        // Rounding of energies of K over 2 e, and e^2 of a third derivative that grows as 1 / J^2.
        CHECK(difference(k) == Approx(P(k)).epsilon(1e-6).margin(1e-7 * m.bulk_modulus));
      }
    }
  }
}

TEST_CASE("The barrier's pressure is K b ln(J / J0), and nothing from J0 up", "[material][barrier]") {
  for (const Material& plain : plainMaterials()) {
    const Material without = plain, with = barred(plain);
    for (const double J : {0.5, 0.50001, 0.8, 1.0, 1.7}) {
      CHECK(with.energy(withJ(J)) == Approx(without.energy(withJ(J))).epsilon(J == 0.5 ? 1e-14 : 0));
      if (J > 0.5) CHECK(with.firstPiola(withJ(J)) == without.firstPiola(withJ(J)));  // to the bit
      CHECK(with.barrierPressure(J) == 0);
    }
    // sigma_barrier = p I: the difference of P F^T / J.
    for (const double J : {0.49, 0.3, 0.1}) {
      const Mat3 F = withJ(J);
      const Mat3 cauchy = (with.firstPiola(F) - without.firstPiola(F)) * F.transpose() / J;
      const double pressure = 1.5 * with.bulk_modulus * std::log(J / 0.5);
      CHECK((cauchy - pressure * Mat3::Identity()).norm() < 1e-12 * with.bulk_modulus);
      CHECK(with.barrierPressure(J) == Approx(pressure).epsilon(1e-13));
      CHECK(pressure < 0);  // it pushes outwards
    }
  }
}

TEST_CASE("The barrier begins smoothly and is finite at collapse and beyond", "[material][barrier]") {
  for (const Material& plain : plainMaterials()) {
    const Material with = barred(plain), without = plain;
    // Stress is continuous at J0; so is the energy with its slope.
    CHECK(std::abs(with.barrierPressure(0.5 - 1e-9)) < 3.1e-9 * with.bulk_modulus);  // K b / J0 times the way
    const double extra = with.energy(withJ(0.5 - 1e-4)) - without.energy(withJ(0.5 - 1e-4));
    CHECK(extra == Approx(with.bulk_modulus * 1.5 * 1e-8 / (2 * 0.5)).epsilon(1e-3));  // K b d^2 / (2 J0)

    double deeper = 0;
    for (const double J : {0.45, 0.3, 0.1, 0.03, 0.02, 0.0, -0.2, -1.0, -10.0}) {
      CHECK(with.firstPiola(withJ(J)).allFinite());
      CHECK(std::isfinite(with.energy(withJ(J))));
      CHECK(with.barrierPressure(J) < deeper);  // the further in, the harder out
      deeper = with.barrierPressure(J);
    }
    // The tangent below min_isochoric_J: no kink.
    const double c = Material::min_isochoric_J, e = 1e-6;
    const double above = (with.barrierPressure(c + e) - with.barrierPressure(c)) / e,
                 below = (with.barrierPressure(c) - with.barrierPressure(c - e)) / e;
    CHECK(above == Approx(below).epsilon(1e-3));
    CHECK(with.firstPiola(Mat3::Zero()).allFinite());
  }
}

TEST_CASE("The lanes' barrier is the scalar one's", "[material][barrier][kernel]") {
  for (const Material& plain : plainMaterials()) {
    const Material m = barred(plain);
    for (const double J : {1.2, 0.55, 0.499, 0.3, 0.1, 0.03, -0.2, -0.8}) {
      const Mat3 F = withJ(J), exact = m.firstPiola(F);
      // Roundings of F times K |cof F| as in registered_laws_test.cpp, the barrier's being b / J times that.
      const double slope = J < m.barrier_J0 ? m.barrier_strength / std::max(J, Material::min_isochoric_J) : 0;
      const double scale = m.bulk_modulus * (1 + F.norm() * F.norm()) * F.norm() * (1 + slope) + exact.norm();
      INFO("J " << J << " double " << (lanesPiola<double>(m, F) - exact).norm() / scale << " float "
                << (lanesPiola<float>(m, F) - exact).norm() / scale);
      CHECK((lanesPiola<double>(m, F) - exact).norm() < 1e-14 * scale);
      // Some thirty roundings of 6e-8; 1.03e-6 where there is no fused multiply-add.
      CHECK((lanesPiola<float>(m, F) - exact).norm() < 2e-6 * scale);
    }
  }
}

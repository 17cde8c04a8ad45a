#include "mechanics/materials/mooney_rivlin.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/kernel_forces.h"
#include "support/law_lanes.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr double c10 = 350, c01 = 150, D1 = 4e-5;  // mu 1000 Pa, K 50 kPa

Material mooneyRivlin(double first = c10, double second = c01) {
  return Material::of("mooney-rivlin").set("c10", first).set("c01", second).set("D1", D1);
}

Mat3 randomF(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> unit(-size, size);
  Mat3 F = Mat3::Identity();
  for (int k = 0; k < 9; ++k) F(k / 3, k % 3) += unit(random);
  return F;
}

/// Irregular states, also with the volume given: nearly collapsed and inverted ones.
std::vector<Mat3> states() {
  std::mt19937 random(11);
  std::vector<Mat3> all{Mat3::Identity(), Vec3(2, 2, 0.25).asDiagonal(), Vec3(0.9, 1.0, -0.2).asDiagonal()};
  for (int k = 0; k < 40; ++k) all.push_back(randomF(random, 0.35));
  for (const double J : {0.6, 0.3, 0.1, 0.01, -0.1, -0.5}) {
    Mat3 F;
    F << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.0;
    F.col(2) *= J / F.determinant();
    all.push_back(F);
  }
  return all;
}

std::vector<Material> variants() {
  Material barred = mooneyRivlin();
  barred.set("barrier_strength", 1.5);
  return {mooneyRivlin(), mooneyRivlin(0, 500), mooneyRivlin(500, 0), barred};
}

/// Rounding of a stress in units of the number's: K (1 + |F|^2) |F| with the barrier's b / J, and c01 |F|^5 / J^(4/3).
double roundingScale(const Material& m, const Mat3& F) {
  const double J = std::max(F.determinant(), Material::min_isochoric_J), norm = F.norm();
  const double barrier = J < m.barrier_J0 ? m.barrier_strength / J : 0;
  return m.bulk_modulus * (1 + norm * norm) * norm * (1 + barrier) +
         m.shear_modulus * std::pow(norm, 5) * std::pow(J, -7.0 / 3);
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

TEST_CASE("Mooney-Rivlin: stress is the derivative of the energy, at rest stiff as its moduli", "[material]") {
  for (const Material& m : variants()) {
    for (const Mat3& F : states()) {
      const Mat3 P = m.firstPiola(F);
      const double e = 1e-6, scale = roundingScale(m, F);
      for (int k = 0; k < 9; ++k) {
        Mat3 ahead = F, behind = F;
        ahead(k / 3, k % 3) += e;
        behind(k / 3, k % 3) -= e;
        // 2e-16 of the energy over 2 e, and e^2 of a third derivative.
        CHECK(std::abs((m.energy(ahead) - m.energy(behind)) / (2 * e) - P(k / 3, k % 3)) < 1e-8 * scale);
      }
    }
    CHECK(m.shear_modulus == Approx(1000));
    CHECK(m.bulk_modulus == Approx(5e4));
    CHECK(m.energy(Mat3::Identity()) == Approx(0).margin(1e-12));
    CHECK(m.firstPiola(Mat3::Identity()).norm() < 1e-12 * m.bulk_modulus);
    const double e = 1e-6;
    Mat3 sheared = Mat3::Identity();
    sheared(0, 1) = e;
    CHECK(m.firstPiola(sheared)(0, 1) / e == Approx(m.shear_modulus).epsilon(1e-5));
    CHECK(m.firstPiola(sheared)(1, 0) / e == Approx(m.shear_modulus).epsilon(1e-5));
    CHECK(m.firstPiola((1 + e) * Mat3::Identity())(2, 2) / e == Approx(3 * m.bulk_modulus).epsilon(1e-5));
    CHECK(m.firstPiola(Vec3(1, 1, 1 + e).asDiagonal())(2, 2) / e == Approx(m.waveModulus()).epsilon(1e-5));
  }
}

TEST_CASE("Mooney-Rivlin with c01 = 0 is the neo-Hookean law", "[material]") {
  const Material m = mooneyRivlin(500, 0);
  const double mu = 1000, K = 2 / D1;
  const Material neo = Material::neoHookean(9 * K * mu / (3 * K + mu), (3 * K - 2 * mu) / (2 * (3 * K + mu)), 1000);
  for (const Mat3& F : states()) {
    const double scale = roundingScale(m, F);
    CHECK((m.firstPiola(F) - neo.firstPiola(F)).norm() < 1e-13 * scale);
    CHECK(std::abs(m.energy(F) - neo.energy(F)) < 1e-13 * scale * (1 + F.norm()));
  }
  Mat3 F = Mat3::Identity();
  F(0, 1) = 1;
  CHECK((mooneyRivlin().firstPiola(F) - neo.firstPiola(F)).norm() > 0.1 * mu);  // and else it is not
}

TEST_CASE("Mooney-Rivlin: the lanes' stress and energy are the scalar ones, in every lane", "[material][kernel]") {
  const auto compare = [](auto number, double rounding) {
    using Real = decltype(number);
    constexpr int width = Simd<Real>::width;
    const auto all = states();
    for (const Material& m : variants())
      for (std::size_t first = 0; first < all.size(); ++first) {
        SimdTensor<Real> H, P;
        alignas(64) Real a[9][width], energy[width], J[width];
        for (int k = 0; k < 9; ++k) {
          for (int i = 0; i < width; ++i)
            a[k][i] = static_cast<Real>(
                (all[(first + static_cast<std::size_t>(i)) % all.size()] - Mat3::Identity())(k / 3, k % 3));
          H[k] = Simd<Real>::load(a[k]);
        }
        const PointStateOf<Real> state = lanesFirstPiola(m, H, P);
        state.energy.store(energy);
        state.J.store(J);
        for (int k = 0; k < 9; ++k) P[k].store(a[k]);
        for (int i = 0; i < width; ++i) {
          const Mat3& F = all[(first + static_cast<std::size_t>(i)) % all.size()];
          Mat3 fast;
          for (int k = 0; k < 9; ++k) fast(k / 3, k % 3) = static_cast<double>(a[k][i]);
          const double scale = roundingScale(m, F);
          INFO("F\n" << F << "\nerror over scale " << (fast - m.firstPiola(F)).norm() / scale);
          CHECK((fast - m.firstPiola(F)).norm() < rounding * scale);
          CHECK(std::abs(static_cast<double>(energy[i]) - m.energy(F)) < 2 * rounding * scale * (1 + F.norm()));
          CHECK(static_cast<double>(J[i]) == Approx(F.determinant()).epsilon(rounding).margin(rounding));
        }
      }
  };
  compare(float{}, 2e-6);  // some thirty roundings of 6e-8, as in material_barrier_test.cpp
  compare(double{}, 1e-14);
}

TEST_CASE("Mooney-Rivlin: each instruction set's kernel equals the reference", "[material][kernel][instructions]") {
  const Material m = mooneyRivlin();
  const TestBody body(6, 0.1, 1, 1.8, 0.1, 0.2, m);
  for (const auto& u : hardStates(body))
    for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
      const auto exact = referenceForces(body, u, patches);
      for (const InstructionSet set : supportedInstructionSets()) {
        const auto fast = fastForces(body, u, 1, nullptr, patches, GradientPrecision::Float32, set);
        INFO(nameOf(set) << ": " << distance(fast, exact) / norm(exact));
        // As in kernel_instructions_test.cpp: float's 1e-6 in J times K / mu.
        CHECK(distance(fast, exact) < 1e-6 * m.bulk_modulus / m.shear_modulus * norm(exact));
      }
    }
}

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "base/build_info.h"
#include "io/csv_table.h"
#include "mechanics/internal_forces.h"
#include "mechanics/materials/laws.h"
#include "support/law_values.h"
#include "support/test_body.h"

using namespace palpate;

namespace {

Material ogden(const std::vector<double>& mu, const std::vector<double>& alpha, double D1 = 1e-4) {
  return Material::ogden(mu.data(), alpha.data(), static_cast<int>(mu.size()), D1, 1000);
}

struct Named {
  std::string name;
  Material material;
};

std::vector<Named> materials() {
  return {{"neo-Hookean, nu 0.49", Material::neoHookean(3000, 0.49, 1000)},
          {"neo-Hookean, nu 0.3", Material::neoHookean(1000, 0.3, 1000)},
          {"Ogden 1, Sylgard", ogden({643.6}, {-1.1}, 1.2598e-4)},
          {"Ogden 2", ogden({400, 250}, {2.5, -3})},
          {"Ogden 3", ogden({630, 1.2, 10}, {1.3, 5, -2})},  // Ogden's rubber in shape, 2 mu / alpha^2 form
          {"Ogden 4", ogden({300, 120, 60, 90}, {1, 2, 3.5, -4})},
          {"Ogden 6", ogden({200, 100, 50, 80, 40, 20}, {0.5, 1.5, 3, -1, -2.5, -4}, 1e-3)}};
}

/// Nominal stresses of the principal stretches l, from the energy as a function of these (paper eq. 32; the
/// neo-Hookean material is alpha = 2), in long double and without the tensor formulas of material.cpp:
///   dW/dl_i = sum_k 2 mu_k/a_k J^(-a_k/3) (l_i^(a_k) - S_k/3) / l_i + K (J - 1) J / l_i,   S_k = sum_j l_j^(a_k)
std::array<long double, 3> principalPiola(const Material& m, const std::array<long double, 3>& l) {
  const bool ogden_kind = m.law == lawNumber<Ogden>();
  const int terms = ogden_kind ? m.term_count : 1;
  const long double J = l[0] * l[1] * l[2];
  std::array<long double, 3> P;
  for (int i = 0; i < 3; ++i) P[i] = m.bulk_modulus * (J - 1) * J / l[i];
  for (int k = 0; k < terms; ++k) {
    const long double a = ogden_kind ? m.get("alpha")[k] : 2, mu = ogden_kind ? m.get("mu")[k] : m.shear_modulus;
    long double S = 0;
    for (long double x : l) S += std::pow(x, a);
    for (int i = 0; i < 3; ++i) P[i] += 2 * mu / a * std::pow(J, -a / 3) * (std::pow(l[i], a) - S / 3) / l[i];
  }
  return P;
}

/// The largest stretch at which `stress` vanishes, by bisection to long double precision. (There may be another at
/// small J, and for compressible materials far in compression only that: (J - 1)^2 has a finite pressure at J = 0,
/// and at nu 0.3 and stretch 0.3 the free sides collapse to J = 0.03. A solution all the same.)
long double freeStretch(const std::function<long double(long double)>& stress) {
  long double high = 20;
  while (high > 0.05L && stress(0.98L * high) > 0) high *= 0.98L;
  long double low = 0.98L * high;
  REQUIRE(stress(low) < 0);
  REQUIRE(stress(high) > 0);
  for (int k = 0; k < 80; ++k) {
    const long double middle = (low + high) / 2;
    (stress(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

Mat3 diagonal(long double a, long double b, long double c) {
  return Vec3(static_cast<double>(a), static_cast<double>(b), static_cast<double>(c)).asDiagonal();
}

const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
const Mat3 tilt = Eigen::AngleAxisd(-0.7, Vec3(0.3, 1, 1).normalized()).toRotationMatrix();

/// firstPiola holds in the principal frame and turned on either side: P(R F Q^T) = R P(F) Q^T.
void checkStress(const Material& m, const Mat3& F, const Mat3& expected) {
  // The stress's rounding is that of the bulk modulus times |cof F|.
  const double scale = m.bulk_modulus * (1 + F.squaredNorm()) + expected.norm();
  CHECK((m.firstPiola(F) - expected).norm() < 1e-13 * scale);
  CHECK((m.firstPiola(turn * F) - turn * expected).norm() < 1e-13 * scale);
  CHECK((m.firstPiola(F * tilt.transpose()) - expected * tilt.transpose()).norm() < 1e-13 * scale);
  CHECK((m.firstPiola(turn * F * tilt.transpose()) - turn * expected * tilt.transpose()).norm() < 1e-13 * scale);
}

std::vector<double> stretches() {
  std::vector<double> l;
  for (double a = 0.3; a < 3.0001; a += 0.1) l.push_back(a);
  l.push_back(1.0 + 1e-9);
  return l;
}

/// The float kernel's forces of one body under the homogeneous F against the double ones, relative.
double kernelError(const test::TestBody& body, const Mat3& F) {
  const auto layout =
      makeKernelLayout(body.shape, body.point_X, body.volume, body.point_material, body.materials, body.nodeCount());
  auto scratch = makeKernelScratch(layout);
  SpinTeam team(1);
  team.wake();
  const auto u = body.displacement(F);
  const auto u4 = test::toFloat4s(u);
  internalForces(layout, makeKernelMaterials(layout, body.materials), u4.data(), scratch, team);
  AlignedVector<Float4> fast(body.X.size());
  sumForces(layout, scratch, 0, body.nodeCount(), fast.data());
  team.park();
  std::vector<Vec3> exact;
  referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, u, exact);
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    difference += (toVec3(fast[i]) - exact[i]).squaredNorm();
    size += exact[i].squaredNorm();
  }
  return std::sqrt(difference / size);
}

}  // namespace

TEST_CASE("Uniaxial stretch with free sides, 0.3 to 3, in any frame", "[material]") {
  for (const auto& [name, m] : materials())
    for (const double l : stretches()) {
      INFO(name << ", stretch " << l);
      const long double side = freeStretch([&m = m, l](long double t) { return principalPiola(m, {t, t, l})[0]; });
      const auto P = principalPiola(m, {side, side, l});
      checkStress(m, diagonal(side, side, l), diagonal(0, 0, P[2]));
    }
}

TEST_CASE("Uniaxial closed form and reference files agree", "[material]") {
  const std::pair<std::string, Material> files[] = {
      {"uniaxial_neo_hookean_E3000_nu0.49.csv", Material::neoHookean(3000, 0.49, 1000)},
      {"uniaxial_neo_hookean_mu210_nu0.49.csv", Material::neoHookean(2 * 210 * 1.49, 0.49, 1000)},
      {"uniaxial_ogden_sylgard.csv", ogden({643.6}, {-1.1}, 1.2598e-4)}};
  for (const auto& [file, m] : files) {
    const CsvTable table = readCsvTable(sourceFolder() + "/tests/reference/" + file);
    CHECK(table.rowCount() > 100);
    for (std::size_t row = 0; row < table.rowCount(); ++row) {
      const double l = table["stretch"][row];
      INFO(file << ", stretch " << l);
      const long double mine = freeStretch([&m = m, l](long double t) { return principalPiola(m, {t, t, l})[0]; });
      CHECK(static_cast<double>(mine) == Approx(table["lateral_stretch"][row]).epsilon(1e-9));
      CHECK(static_cast<double>(principalPiola(m, {mine, mine, l})[2]) ==
            Approx(table["nominal_stress_Pa"][row]).epsilon(1e-6).margin(1e-4));
      CHECK(static_cast<double>(mine * mine * l) == Approx(table["J"][row]).epsilon(1e-9));
    }
  }
}

TEST_CASE("Equibiaxial stretch with free faces, 0.3 to 3, in any frame", "[material]") {
  for (const auto& [name, m] : materials())
    for (const double l : stretches()) {
      INFO(name << ", stretch " << l);
      const long double thick = freeStretch([&m = m, l](long double t) { return principalPiola(m, {l, l, t})[2]; });
      const auto P = principalPiola(m, {l, l, thick});
      checkStress(m, diagonal(l, l, thick), diagonal(P[0], P[1], 0));
    }
}

TEST_CASE("Simple shear, 0 to 2: shear stress from the energy, and Rivlin's universal relation", "[material]") {
  // gamma = l - 1/l with stretches l, 1/l, 1 and J = 1. The shear stress dW/dgamma:
  //   tau = sum_k 2 mu_k/a_k (l^a_k - l^-a_k) / (l + 1/l)      (neo-Hookean: mu gamma)
  // For every isotropic elastic material, Cauchy s11 - s22 = gamma s12.
  for (const auto& [name, m] : materials())
    for (double gamma = 0; gamma < 2.0001; gamma += 0.1) {
      INFO(name << ", shear " << gamma);
      const double l = gamma / 2 + std::sqrt(1 + gamma * gamma / 4);
      double tau = m.law == lawNumber<NeoHookean>() ? m.shear_modulus * gamma : 0;
      for (int k = 0; k < m.term_count; ++k) {
        const double mu = m.get("mu")[k], alpha = m.get("alpha")[k];
        tau += 2 * mu / alpha * (std::pow(l, alpha) - std::pow(l, -alpha)) / (l + 1 / l);
      }
      Mat3 F = Mat3::Identity();
      F(0, 1) = gamma;
      for (const Mat3& R : {Mat3(Mat3::Identity()), turn}) {
        const Mat3 cauchy = R.transpose() * m.firstPiola(R * F) * F.transpose();  // J = 1; turned back
        const double tolerance = 1e-13 * m.bulk_modulus * (1 + F.squaredNorm());
        CHECK(std::abs(cauchy(0, 1) - tau) < tolerance);
        CHECK(std::abs(cauchy(1, 0) - tau) < tolerance);
        CHECK(std::abs(cauchy(0, 0) - cauchy(1, 1) - gamma * tau) < 3 * tolerance);
        CHECK(std::abs(cauchy(0, 2)) + std::abs(cauchy(1, 2)) < tolerance);
      }
    }
}

TEST_CASE("At repeated and nearly repeated stretches the stress is still the energy's derivative", "[material]") {
  const double gaps[] = {0, 1e-12, 1e-9, 1e-6, 1e-3};
  for (const auto& [name, m] : materials())
    for (const double gap : gaps)
      for (const Vec3& l : {Vec3(1, 1, 1), Vec3(1.3, 1.3, 1.3), Vec3(2, 2, 0.25), Vec3(0.3, 1.8, 1.8)}) {
        const Mat3 F = turn * Vec3(l[0], l[1] * (1 + gap), l[2] * (1 - gap)).asDiagonal() * tilt.transpose();
        INFO(name << ", stretches " << l.transpose() << ", gap " << gap);
        // e^2 times third derivatives (of order K |F|^3 and of the largest power of the least stretch), and
        // the rounding of W over e.
        CHECK((test::energyDifferences(m, F, 1e-5) - m.firstPiola(F)).norm() <
              2e-7 * m.bulk_modulus * (1 + F.squaredNorm()));
      }
}

TEST_CASE("The float kernel gives the closed-form states' forces", "[material][kernel]") {
  for (const auto& [name, m] : materials()) {
    // Two nodes to an edge are 8 nodes and 6 cells, one point each: linear fields only, F is the same in all.
    const test::TestBody body(2, 0.01, 1, 3.0, 0.1, 0, m);
    for (const double l : {0.3, 0.6, 0.9, 1.5, 3.0}) {
      const long double side = freeStretch([&m = m, l](long double t) { return principalPiola(m, {t, t, l})[0]; });
      const long double thick = freeStretch([&m = m, l](long double t) { return principalPiola(m, {l, l, t})[2]; });
      Mat3 shear = Mat3::Identity();
      shear(0, 1) = 2 * (l - 0.3) / 2.7 + 0.1;
      for (const Mat3& F :
           {Mat3(diagonal(side, side, l)), Mat3(turn * diagonal(l, l, thick) * tilt.transpose()), shear}) {
        INFO(name << ", stretch " << l << "\nF\n" << F);
        if (F.determinant() < 0.1) continue;  // collapsed: float loses J's digits, which powers of 1/J magnify
        // F rounds at 6e-8 and the bulk modulus over the stress multiplies that.
        const double scale = m.bulk_modulus * (1 + F.squaredNorm()) * F.norm() / m.firstPiola(F).norm();
        CHECK(kernelError(body, F) < 1e-6 * (scale + 1));
      }
    }
  }
}

TEST_CASE("Ogden materials have one to six terms", "[material][input]") {
  const std::vector<double> seven(7, 1.0);
  CHECK_THROWS_AS(Material::ogden(seven.data(), seven.data(), 7, 1e-4, 1000), std::invalid_argument);
  CHECK_THROWS_AS(Material::ogden(seven.data(), seven.data(), 0, 1e-4, 1000), std::invalid_argument);
  CHECK(Material::ogden(seven.data(), seven.data(), 6, 1e-4, 1000).shear_modulus == Approx(6));
}

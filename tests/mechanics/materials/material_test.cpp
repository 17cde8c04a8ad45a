#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <fstream>
#include <random>
#include <sstream>

#include "base/build_info.h"
#include "mechanics/materials/material.h"
#include "support/law_lanes.h"

using namespace palpate;

namespace {

Material sylgard() {
  const double mu = 643.6, alpha = -1.1;
  return Material::ogden(&mu, &alpha, 1, 1.2598e-4, 970);
}
Material twoTerm() {
  const double mu[] = {400, 250}, alpha[] = {2.5, -3};
  return Material::ogden(mu, alpha, 2, 1e-4, 1000);
}
std::vector<Material> allMaterials() {
  return {Material::neoHookean(3000, 0.49, 1000), Material::neoHookean(1000, 0.3, 1000), sylgard(), twoTerm()};
}

Mat3 randomF(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> unit(-size, size);
  Mat3 F = Mat3::Identity();
  for (int k = 0; k < 9; ++k) F(k / 3, k % 3) += unit(random);
  return F;
}

struct Row {
  double stretch, lateral, stress, J;
};
std::vector<Row> readUniaxial(const std::string& name) {
  std::ifstream file(sourceFolder() + "/tests/reference/" + name);
  REQUIRE(file);
  std::vector<Row> rows;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream in(line);
    Row r{};
    in >> r.stretch >> r.lateral >> r.stress >> r.J;
    rows.push_back(r);
  }
  return rows;
}

/// The lanes' stress of one F, in double.
Mat3 lanesPiola(const Material& m, const Mat3& F, float* J = nullptr, float* energy = nullptr) {
  SimdTensor<float> H, P;
  for (int k = 0; k < 9; ++k) H[k] = static_cast<float>((F - Mat3::Identity())(k / 3, k % 3));
  const PointStateOf<float> state = test::lanesFirstPiola(m, H, P);
  Mat3 r;
  alignas(64) float a[Simd<float>::width];
  for (int k = 0; k < 9; ++k) {
    P[k].store(a);
    r(k / 3, k % 3) = a[Simd<float>::width - 1];
  }
  state.J.store(a);
  if (J) *J = a[Simd<float>::width - 1];
  state.energy.store(a);
  if (energy) *energy = a[Simd<float>::width - 1];
  return r;
}

}  // namespace

TEST_CASE("Stress is the derivative of the energy", "[material]") {
  std::mt19937 random(4);
  for (const auto& m : allMaterials())
    for (int trial = 0; trial < 20; ++trial) {
      Mat3 F = randomF(random, 0.4);
      if (F.determinant() < 0.2) continue;
      const Mat3 P = m.firstPiola(F);
      const double e = 1e-5;
      for (int k = 0; k < 9; ++k) {
        Mat3 ahead = F, behind = F;
        ahead(k / 3, k % 3) += e;
        behind(k / 3, k % 3) -= e;
        const double difference = (m.energy(ahead) - m.energy(behind)) / (2 * e);
        CHECK(difference == Approx(P(k / 3, k % 3)).margin(1e-6 * m.bulk_modulus));
      }
    }
}

TEST_CASE("Inverted states have a finite stress that is still the energy's derivative", "[material]") {
  for (const auto& m : allMaterials()) {
    Mat3 F = Vec3(0.9, 1.1, -0.3).asDiagonal();
    const Mat3 P = m.firstPiola(F);
    REQUIRE(P.allFinite());
    const double e = 1e-6;
    Mat3 ahead = F, behind = F;
    ahead(2, 2) += e;
    behind(2, 2) -= e;
    CHECK((m.energy(ahead) - m.energy(behind)) / (2 * e) == Approx(P(2, 2)).epsilon(1e-4));
    CHECK(P(2, 2) < 0);  // f = -dW/dF pushes the point back towards J > 0
  }
}

TEST_CASE("No crushed or inverted point has less energy than none", "[material][kernel]") {
  for (const auto& m : allMaterials())
    for (const double J : {0.03, 0.019, 0.01, 0.002, -0.02, -0.3})
      for (const double l : {0.2, 0.5, 1.0}) {
        const Mat3 F = Vec3(1 / l, l, J).asDiagonal();
        CAPTURE(m.lawDescription().name, J, l);
        float lanes = 0;
        const Mat3 P = m.firstPiola(F), of_lanes = lanesPiola(m, F, nullptr, &lanes);
        CHECK(m.energy(F) > 0);
        CHECK(lanes == Approx(m.energy(F)).epsilon(0.01));
        CHECK((of_lanes - P).norm() <= 0.02 * P.norm());
      }
}

TEST_CASE("Rotations do no work and turn the stress", "[material]") {
  std::mt19937 random(9);
  const Mat3 R = Eigen::AngleAxisd(1.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const auto& m : allMaterials()) {
    CHECK(m.firstPiola(R).norm() < 1e-9 * m.bulk_modulus);
    const Mat3 F = randomF(random, 0.25);
    CHECK((m.firstPiola(R * F) - R * m.firstPiola(F)).norm() < 1e-9 * m.bulk_modulus);
    CHECK(m.energy(R * F) == Approx(m.energy(F)));
  }
}

TEST_CASE("Uniaxial stress with free sides follows the closed form from stretch 0.3 to 3", "[material]") {
  const double mu210 = 2 * 210 * 1.49;  // E of mu = 210 Pa, nu = 0.49
  const std::pair<std::string, Material> cases[] = {
      {"uniaxial_neo_hookean_E3000_nu0.49.csv", Material::neoHookean(3000, 0.49, 1000)},
      {"uniaxial_neo_hookean_mu210_nu0.49.csv", Material::neoHookean(mu210, 0.49, 1000)},
      {"uniaxial_ogden_sylgard.csv", sylgard()}};
  for (const auto& [file, m] : cases)
    for (const auto& row : readUniaxial(file)) {
      const Mat3 F = Vec3(row.lateral, row.lateral, row.stretch).asDiagonal();
      const Mat3 P = m.firstPiola(F);
      INFO(file << " stretch " << row.stretch);
      CHECK(P(2, 2) == Approx(row.stress).epsilon(1e-6).margin(1e-4));
      // The reference gives 12 digits of the lateral stretch; the bulk modulus multiplies the rest.
      CHECK(std::abs(P(0, 0)) < 1e-9 * m.bulk_modulus);
      CHECK(F.determinant() == Approx(row.J).epsilon(1e-9));
    }
}

TEST_CASE("Simple shear of the neo-Hookean material: shear stress mu * gamma", "[material]") {
  const auto m = Material::neoHookean(3000, 0.49, 1000);
  for (const double gamma : {0.1, 0.5, 1.0, 2.0}) {
    Mat3 F = Mat3::Identity();
    F(0, 1) = gamma;
    const Mat3 cauchy = m.firstPiola(F) * F.transpose();
    CHECK(cauchy(0, 1) == Approx(m.shear_modulus * gamma).epsilon(1e-12));
    CHECK(cauchy(0, 0) - cauchy(1, 1) == Approx(m.shear_modulus * gamma * gamma).epsilon(1e-12));
  }
}

TEST_CASE("Equibiaxial stretch of Ogden material matches its principal stress formula", "[material]") {
  const auto m = twoTerm();
  const auto mu = m.get("mu"), alpha = m.get("alpha");
  for (const double l : {0.3, 0.7, 1.0, 1.0000001, 1.5, 3.0}) {
    const double t = 1 / (l * l);  // isochoric: J = 1, no volumetric stress
    const Mat3 F = Vec3(l, l, t).asDiagonal();
    const Mat3 P = m.firstPiola(F);
    double difference = 0;  // Cauchy s1 - s3 = sum 2 mu/a (l^a - t^a)
    for (int k = 0; k < 2; ++k) difference += 2 * mu[k] / alpha[k] * (std::pow(l, alpha[k]) - std::pow(t, alpha[k]));
    CHECK(P(0, 0) * l - P(2, 2) * t == Approx(difference).epsilon(1e-10).margin(1e-9));
    CHECK(P(0, 0) == Approx(P(1, 1)).epsilon(1e-12).margin(1e-12));
  }
}

TEST_CASE("The 16-lane float stress equals the double one", "[material][kernel]") {
  std::mt19937 random(5);
  for (const auto& m : allMaterials()) {
    // Rest, repeated stretches, rotations by 90 degrees, 75 % compression, shear, inversion.
    std::vector<Mat3> states{Mat3::Identity(), Mat3(1.1 * Mat3::Identity()), Mat3(Vec3(2, 2, 0.25).asDiagonal()),
                             Mat3(Vec3(1.9, 2.05, 0.25).asDiagonal()), Mat3(Vec3(0.9, 1.0, -0.2).asDiagonal())};
    for (int k = 0; k < 30; ++k) states.push_back(randomF(random, 0.35));
    const Mat3 R = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()).toRotationMatrix();
    const std::size_t plain = states.size();
    for (std::size_t k = 0; k < plain; ++k) states.push_back(R * states[k]);
    for (const auto& F : states) {
      if (F.determinant() > 0 && F.determinant() < 0.05) continue;
      float J = 0, energy = 0;
      const Mat3 fast = lanesPiola(m, F, &J, &energy), exact = m.firstPiola(F);
      INFO("F\n" << F << "\nfast\n" << fast << "\nexact\n" << exact);
      CHECK(J == Approx(F.determinant()).epsilon(1e-6).margin(1e-6));
      // F itself rounds at 6e-8 |F| and the bulk modulus times |cof F| multiplies that.
      const double scale = m.bulk_modulus * (1 + F.norm() * F.norm()) * F.norm() + exact.norm();
      CHECK((fast - exact).norm() < 1e-6 * scale);
      CHECK(std::abs(energy - m.energy(F)) < 2e-6 * (scale * F.norm() + m.energy(F)));
    }
  }
}

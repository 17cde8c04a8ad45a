// What a law promises, for every registered one: stress and energy, the fast stress, the bound of its tangent.

#include <Eigen/Eigenvalues>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "mechanics/local_mass.h"
#include "support/kernel_forces.h"
#include "support/law_lanes.h"
#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

namespace {

template <class Call>
void forEachLaw(Call call) {
  for (const MaterialLaw& law : materialLaws())
    for (const Material& m : plausibleMaterials(law)) {
      INFO(law.name << ": mu " << m.shear_modulus << ", K " << m.bulk_modulus << ", values " << m.value[0] << " "
                    << m.value[1] << " " << m.value[2] << " " << m.value[3] << ", b " << m.barrier_strength);
      call(m);
    }
}

/// The law's bound of its tangent at F: with the s of |cof F|^2, as the loop has it, and with the true one.
struct Bound {
  double estimated, exact;
};
Bound boundOf(const Material& m, const Mat3& F) {
  SimdTensor<double> H, P;
  for (int k = 0; k < 9; ++k) H[k] = (F - Mat3::Identity())(k / 3, k % 3);
  const auto state = lanesFirstPiola(m, H, P);
  std::array<float, 16> cof2, J, squeeze, other, modulus;
  cof2.fill(static_cast<float>(state.cof2.v[0]));
  J.fill(static_cast<float>(state.J.v[0]));
  squeeze.fill(static_cast<float>(state.squeeze.v[0]));
  other.fill(static_cast<float>(state.other.v[0]));
  squeezedModulus(cof2.data(), J.data(), squeeze.data(), other.data(), modulus.data());
  const double least = Eigen::SelfAdjointEigenSolver<Mat3>(F.transpose() * F).eigenvalues()[0];
  const double s2 = state.J.v[0] * state.J.v[0] / least;
  return {static_cast<double>(modulus[0]), state.squeeze.v[0] * s2 + state.other.v[0]};
}

/// The largest eigenvalue of the acoustic tensor for waves along n, by differences of the stress.
double acoustic(const Material& m, const Mat3& F, const Vec3& n) {
  constexpr double h = 1e-6;
  Mat3 Q;
  for (int i = 0; i < 3; ++i) {
    Mat3 ahead = F, behind = F;
    ahead.row(i) += h * n.transpose();
    behind.row(i) -= h * n.transpose();
    Q.col(i) = (m.firstPiola(ahead) - m.firstPiola(behind)) * n / (2 * h);
  }
  return Eigen::SelfAdjointEigenSolver<Mat3>(0.5 * (Q + Q.transpose())).eigenvalues()[2];
}

/// Axes, what lies between them in steps of 15 degrees, and the fibres.
std::vector<Vec3> directions(const Material& m) {
  constexpr int n = 6;
  std::vector<Vec3> all;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n - i; ++j)
      for (const int sign_i : {1, -1})
        for (const int sign_j : {1, -1}) all.push_back(Vec3(sign_i * i, sign_j * j, n - i - j).normalized());
  if (m.fibre_modulus > 0) all.emplace_back(m.fibre[0], m.fibre[1], m.fibre[2]);
  return all;
}

/// Rounding of a stress in units of the number's: of F by the tangent, and of the sum.
double roundingScale(const Material& m, const Mat3& F) {
  const Mat3 P = m.firstPiola(F);
  return std::abs(boundOf(m, F).estimated) * (1 + F.squaredNorm()) * F.norm() + P.norm() * F.norm() * F.norm();
}

}  // namespace

TEST_CASE("Stress is the derivative of the energy and turns with the tissue, whatever the law", "[material][law]") {
  const Mat3 turn = Eigen::AngleAxisd(1.9, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  forEachLaw([&](const Material& m) {
    for (const Mat3& F : irregularStates()) {
      const Mat3 P = m.firstPiola(F);
      const double e = 1e-6, scale = roundingScale(m, F);
      // 2e-16 of the energy over 2 e, e^2 of a third derivative, and a kink of the stress where fibres begin to bear.
      const Mat3 error = energyDifferences(m, F, e) - P;
      INFO("F\n" << F << "\nerror\n" << error);
      CHECK((error.array().abs() < 1e-8 * scale + e * m.fibre_modulus).all());
      // Turning what is deformed turns the stress and does no work.
      CHECK((m.firstPiola(turn * F) - turn * P).norm() < 1e-14 * scale);
      CHECK(std::abs(m.energy(turn * F) - m.energy(F)) < 1e-14 * scale * (1 + F.norm()));
    }
    CHECK(m.energy(Mat3::Identity()) == Approx(0).margin(1e-12 * m.bulk_modulus));
    CHECK(m.firstPiola(Mat3::Identity()).norm() < 1e-12 * m.bulk_modulus);
  });
}

TEST_CASE("At rest a material is as stiff as its moduli say, whatever the law", "[material][law]") {
  forEachLaw([](const Material& m) {
    const Vec3 n(m.fibre[0], m.fibre[1], m.fibre[2]);
    const double e = 1e-6;
    for (int k = 0; k < 9; ++k) {
      Mat3 H = Mat3::Zero();
      H(k / 3, k % 3) = n[k / 3] * n[k % 3] < 0 ? -e : e;  // fibres are stretched
      const Mat3 hooke = m.shear_modulus * (H + H.transpose()) +
                         ((m.bulk_modulus - 2.0 / 3 * m.shear_modulus) * H.trace()) * Mat3::Identity() +
                         m.fibre_modulus * n.dot(H * n) * n * n.transpose();
      const Mat3 P = m.firstPiola(Mat3::Identity() + H);
      CHECK((P - hooke).norm() < 3e-5 * e * m.waveModulus());
    }
  });
}

TEST_CASE("The lanes' stress and energy are the scalar ones, in every lane, whatever the law",
          "[material][law][kernel]") {
  const auto compare = [](auto number, double rounding) {
    using Real = decltype(number);
    constexpr int width = Simd<Real>::width;
    const auto all = irregularStates();
    forEachLaw([&](const Material& m) {
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
    });
  };
  compare(float{}, 2e-6);  // some thirty roundings of 6e-8, as in material_barrier_test.cpp
  compare(double{}, 1e-14);
}

TEST_CASE("Each instruction set's kernel equals the reference, whatever the law",
          "[material][law][kernel][instructions]") {
  for (const MaterialLaw& law : materialLaws()) {
    const Material m = plausibleMaterials(law, 1).front();
    const TestBody body(5, 0.1, 1, 1.8, 0.1, 0.2, m);
    for (const auto& u : hardStates(body))
      for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
        const auto exact = referenceForces(body, u, patches);
        for (const InstructionSet set : supportedInstructionSets()) {
          const auto fast = fastForces(body, u, 1, nullptr, patches, GradientPrecision::Float32, set);
          INFO(law.name << ", " << nameOf(set) << ": " << distance(fast, exact) / norm(exact));
          // As in kernel_instructions_test.cpp: float's 1e-6 in J times K / mu.
          CHECK(distance(fast, exact) < 1e-6 * std::max(10.0, m.bulk_modulus / m.shear_modulus) * norm(exact));
        }
      }
  }
}

TEST_CASE("A law's bound of its tangent is that of the acoustic tensor, principal stretches 0.3 to 3",
          "[material][law][local_mass]") {
  constexpr int steps = 6;
  const auto stretch = [](int k) { return 0.3 * std::pow(10, static_cast<double>(k) / steps); };
  forEachLaw([&](const Material& m) {
    const auto all = directions(m);
    double least = 2, most = 0, most_estimated = 0;
    for (int a = 0; a <= steps; ++a)
      for (int b = 0; b <= steps; ++b)
        for (int c = 0; c <= steps; ++c) {
          if (m.fibre_modulus == 0 && (a < b || b < c)) continue;  // isotropic: the order means nothing
          const Mat3 F = Vec3(stretch(a), stretch(b), stretch(c)).asDiagonal();
          const double J = F.determinant();
          if (m.barrier_strength > 0 && std::abs(J - m.barrier_J0) < 1e-3) continue;  // a kink
          double exact = 0;
          for (const Vec3& n : all) exact = std::max(exact, acoustic(m, F, n));
          const Bound bound = boundOf(m, F);
          least = std::min({least, bound.exact / exact, bound.estimated / exact});
          most = std::max(most, bound.exact / exact);
          most_estimated = std::max(most_estimated, bound.estimated / exact);
        }
    INFO(least << " .. " << most << ", estimated up to " << most_estimated);
    CHECK(least > 1 - 1e-3);  // a law below it would lose its state where it is squeezed
    CHECK(most < (m.fibre_modulus > 0 ? 2 : 1.2));
    CHECK(most_estimated < 4.5);  // s, of three stretches from one number, is up to a factor 2 too large
    // At rest, fibres just stretched: the modulus that the time step was chosen for.
    CHECK(boundOf(m, 1.000001 * Mat3::Identity()).exact == Approx(m.waveModulus()).epsilon(1e-4));
  });
}

#include "mechanics/relaxation.h"

#include <catch2/catch.hpp>
#include <limits>

#include "mechanics/internal_forces.h"
#include "support/kernel_forces.h"
#include "support/law_values.h"

using namespace palpate;
using namespace palpate::test;

namespace {

const std::vector<double> two_terms{0.3, 0.1, 0.25, 0.7};

Material relaxing(Material m, const std::vector<double>& pairs = two_terms) { return m.set("relaxation", pairs); }

Mat3 sheared(double gamma) {
  Mat3 F = Mat3::Identity();
  F(0, 1) = gamma;
  return F;
}

/// P_iso of the law.
Mat3 isochoric(const Material& m, const Mat3& F) {
  const Mat3 P = m.firstPiola(F);
  return P - P.cwiseProduct(F).sum() / 3 * F.inverse().transpose();
}

/// Forces of the points one by one by relaxedStress, and the sums that the kernel reports.
struct PlainForces {
  const TestBody& body;
  const NodePatches& patches;
  double h;
  std::vector<Mat3> Z = std::vector<Mat3>(body.volume.size() * 3, Mat3::Zero());
  std::vector<Vec3> f = {};
  double energy = 0, power = 0;

  void step(const std::vector<Vec3>& u) {
    std::vector<Mat3> F;
    std::vector<double> pressure;
    for (int q = 0; q < body.shape.rowCount(); ++q) {
      F.push_back(deformationGradient(body.shape, q, u));
      pressure.push_back(F.back().determinant() - 1);
      if (patches.empty()) pressure.back() *= body.materials[body.point_material[q]].bulk_modulus;
    }
    if (!patches.empty()) pressure = patchPressure(patches, body.volume, pressure);
    f.assign(u.size(), Vec3::Zero());
    energy = power = 0;
    for (int q = 0; q < body.shape.rowCount(); ++q) {
      const Material& m = body.materials[body.point_material[q]];
      const RelaxedStress stress = relaxedStress(relaxationStep(m, h), F[q], m.firstPiola(F[q], pressure[q]),
                                                 &Z[3 * static_cast<std::size_t>(q)]);
      energy += body.volume[q] * stress.energy;
      power += body.volume[q] * stress.power;
      for (int e = body.shape.begin[q]; e < body.shape.begin[q + 1]; ++e)
        f[body.shape.node[e]] -= body.volume[q] * stress.P * body.shape.gradN[e];
    }
  }
};

/// The kernel with a history of its own.
template <class Real>
struct FastForces {
  const TestBody& body;
  KernelLayoutOf<Real> layout;
  KernelMaterialsOf<Real> materials = makeKernelMaterials(layout, body.materials);
  KernelScratchOf<Real> scratch;
  RelaxationHistoryOf<Real> history = makeRelaxationHistory<Real>(layout.batch_material.size(), materials.materials);
  ForceReport report = {};

  FastForces(const TestBody& b, const NodePatches& patches, InstructionSet set = chosenInstructionSet())
      : body(b),
        layout(makeKernelLayout<Real>(b.shape, b.point_X, b.volume, b.point_material, b.materials, b.nodeCount(),
                                      patches)),
        scratch(makeKernelScratch(layout, set)) {}

  /// @param h  s; 0: the equilibrium
  std::vector<Vec3> step(const std::vector<Vec3>& u, double h, int threads = 1) {
    SpinTeam workers(threads);
    workers.wake();
    AlignedVector<Real4<Real>> u4, f(u.size());
    for (const auto& a : u) u4.push_back(toReal4<Real>(a));
    report = internalForces(layout, materials, u4.data(), scratch, workers, h > 0 ? &history : nullptr, h);
    sumForces(layout, scratch, 0, body.nodeCount(), f.data());
    workers.park();
    std::vector<Vec3> result;
    for (const auto& a : f) result.push_back(toVec3(a));
    return result;
  }
};

/// Points of three materials: with two terms, with one, with none.
TestBody patchwork() {
  const Material soft = Material::neoHookean(3000, 0.49, 1000);
  TestBody body(5, 0.1, 1, 1.8, 0.1, 0.2, relaxing(soft));
  body.materials.push_back(relaxing(ogden(), {0.5, 0.05}));
  body.materials.push_back(soft);
  for (std::size_t q = 0; q < body.point_material.size(); ++q) body.point_material[q] = static_cast<int>(q / 100 % 3);
  return body;
}

}  // namespace

TEST_CASE("At a held strain the isochoric stress of every law relaxes by the Prony series, the pressure stays",
          "[relaxation]") {
  Mat3 F;
  F << 1.1, 0.4, 0, -0.1, 0.9, 0.05, 0.1, 0, 1.05;
  for (const MaterialLaw& law : materialLaws())
    for (const double h : {1e-3, 0.3}) {
      const Material m = relaxing(sampleMaterial(law));
      const RelaxationStep step = relaxationStep(m, h);
      std::vector<Mat3> Z(2, Mat3::Zero());
      INFO(law.name << ", steps of " << h << " s");
      for (int k = 1; k <= 20; ++k) {  // the stress comes on in the first step, in which S goes straight up
        double left = 1;
        for (std::size_t i = 0; i < 4; i += 2) {
          const double tau = two_terms[i + 1];
          left -= two_terms[i] * (1 - tau / h * -std::expm1(-h / tau) * std::exp(-(k - 1) * h / tau));
        }
        const Mat3 expected = m.firstPiola(F) - (1 - left) * isochoric(m, F);
        const Mat3 P = relaxedStress(step, F, m.firstPiola(F), Z.data()).P;
        REQUIRE((P - expected).norm() < 1e-12 * m.firstPiola(F).norm());
      }
      const Mat3 end = relaxedStress(relaxationStep(m, std::numeric_limits<double>::infinity()), F, m.firstPiola(F)).P;
      CHECK((end - m.firstPiola(F) + 0.55 * isochoric(m, F)).norm() < 1e-12 * m.firstPiola(F).norm());
      CHECK(m.longTermShare() == Approx(0.45).epsilon(1e-15));
    }
}

TEST_CASE("Under a constant shear stress a point creeps as the standard linear solid does", "[relaxation]") {
  // gamma(t) = s / G0 (1 - g e^(-(1 - g) t / tau)) / (1 - g)
  constexpr double g = 0.4, tau = 0.2, h = tau / 1000;
  const Material m = relaxing(Material::neoHookean(3000, 0.49, 1000), {g, tau});
  const double stress = 1e-3 * m.shear_modulus;  // small: strains of 1e-3, where the law is linear
  const RelaxationStep step = relaxationStep(m, h);
  Mat3 Z = Mat3::Zero();
  double gamma = 0, worst = 0;
  const auto stressAt = [&](double shear, Mat3 at) {
    const Mat3 F = sheared(shear);
    return relaxedStress(step, F, m.firstPiola(F), &at).P(0, 1);
  };
  for (int k = 1; k <= 16000; ++k) {
    for (int n = 0; n < 3; ++n) gamma += (stress - stressAt(gamma, Z)) / (m.shear_modulus * (1 - step.term[0].now));
    const Mat3 F = sheared(gamma);
    relaxedStress(step, F, m.firstPiola(F), &Z);
    const double t = (k - 0.5) * h;  // the load comes on within the first step
    const double exact = stress / m.shear_modulus * (1 - g * std::exp(-(1 - g) * t / tau)) / (1 - g);
    worst = std::max(worst, std::abs(gamma / exact - 1));
  }
  CHECK(gamma == Approx(stress / m.shear_modulus / (1 - g)).epsilon(1e-3));
  CHECK(worst < 1e-3);  // h / tau at the start
}

TEST_CASE("The history is second order in the step, and what it keeps from the energy is known without past strains",
          "[relaxation]") {
  const Material m = relaxing(Material::neoHookean(3000, 0.49, 1000));
  struct Cycle {
    double stress = 0, work = 0, identity = 0;  // P_12 on the way back, work of P, the same by energy and power
  };
  const auto cycle = [&m](int steps) {
    const double h = 1.0 / steps;
    const RelaxationStep step = relaxationStep(m, h);
    std::vector<Mat3> Z(2, Mat3::Zero());
    Mat3 F0 = Mat3::Identity(), P0 = Mat3::Zero();
    double power = 0, flow = 0;
    Cycle result;
    for (int k = 1; k <= steps; ++k) {
      Mat3 F = sheared(0.5 * std::sin(M_PI * k * h));
      F(2, 2) = 1 + 0.1 * std::sin(M_PI * k * h);
      const RelaxedStress now = relaxedStress(step, F, m.firstPiola(F), Z.data());
      result.work += 0.5 * (now.P + P0).cwiseProduct(F - F0).sum();
      flow += 0.5 * h * (power + now.power);
      power = now.power;
      result.identity = m.energy(F) - (now.energy - flow);
      if (4 * k == 3 * steps) result.stress = now.P(0, 1);
      F0 = F;
      P0 = now.P;
    }
    return result;
  };
  const Cycle coarse = cycle(40), middle = cycle(80), fine = cycle(160), exact = cycle(8000);
  CHECK((coarse.stress - exact.stress) / (middle.stress - exact.stress) == Approx(4).epsilon(0.1));
  CHECK((middle.stress - exact.stress) / (fine.stress - exact.stress) == Approx(4).epsilon(0.1));
  CHECK(exact.work > 0.01 * m.shear_modulus * 0.125);  // a closed way: what was lost
  CHECK(exact.identity == Approx(exact.work).epsilon(1e-5));
}

TEST_CASE("The kernel relaxes as the plain formulas do, point by point, in every instruction set",
          "[relaxation][kernel]") {
  const TestBody body = patchwork();
  const auto states = hardStates(body);
  for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
    PlainForces plain{body, patches, 0.02};
    FastForces<double> in_double(body, patches);
    std::vector<FastForces<float>> in_float;
    for (const InstructionSet set : supportedInstructionSets()) in_float.emplace_back(body, patches, set);
    for (int k = 0; k < 6; ++k) {
      const auto& u = states[static_cast<std::size_t>(k) % states.size()];
      plain.step(u);
      const auto exact = in_double.step(u, plain.h);
      CHECK(distance(exact, plain.f) < 1e-12 * norm(plain.f));
      CHECK(in_double.report.relaxed_energy == Approx(plain.energy).epsilon(1e-9));
      CHECK(in_double.report.relaxation_power == Approx(plain.power).epsilon(1e-9));
      const double ratio = body.materials[0].bulk_modulus / body.materials[0].shear_modulus;
      for (auto& fast : in_float) {
        CHECK(distance(fast.step(u, plain.h), exact) < 1e-6 * ratio * norm(exact));  // internal_forces_test.cpp
        CHECK(fast.report.relaxed_energy == Approx(plain.energy).epsilon(1e-4));
      }
    }
  }
}

TEST_CASE("Without a history the kernel has the equilibrium: the law with the shear modulus that is left",
          "[relaxation][kernel]") {
  const Material m = Material::neoHookean(3000, 0.45, 1000);
  const double K = m.bulk_modulus, mu = 0.45 * m.shear_modulus;
  const Material left = Material::neoHookean(9 * K * mu / (3 * K + mu), (3 * K - 2 * mu) / (2 * (3 * K + mu)), 1000);
  const TestBody body(5, 0.1, 1, 1.8, 0.1, 0.2, relaxing(m)), twin(5, 0.1, 1, 1.8, 0.1, 0.2, left);
  for (const auto& u : hardStates(body)) {
    const auto relaxed = FastForces<double>(body, body.patches()).step(u, 0);
    CHECK(distance(relaxed, referenceForces(twin, u, twin.patches())) < 1e-12 * norm(relaxed));
  }
}

TEST_CASE("An inverted point leaves a finite history, and any number of threads the same bits",
          "[relaxation][kernel][determinism]") {
  const TestBody body = patchwork();
  auto thrown = body.displacement(Mat3::Identity());
  thrown[62] += Vec3(0.2, 0, 0);
  const auto rest = body.displacement(Mat3::Identity());
  std::vector<AlignedVector<float>> histories;
  for (const int threads : {1, 3}) {
    FastForces<float> fast(body, body.patches());
    for (int k = 0; k < 5; ++k) fast.step(thrown, 1e-3, threads);
    REQUIRE(fast.report.inverted_points > 0);
    histories.push_back(fast.history.Z);
    const auto after = norm(fast.step(rest, 1e-3, threads));
    CHECK(std::isfinite(after));
    for (int k = 0; k < 700; ++k) fast.step(rest, 0.02, threads);
    const auto never = FastForces<float>(body, body.patches()).step(rest, 0.02);  // Ogden's rounding
    CHECK(distance(fast.step(rest, 0.02, threads), never) < 1e-8 * after);        // e^(-14 / 0.7)
  }
  CHECK(histories[0] == histories[1]);
  double largest = 0;
  for (const float z : histories[0]) {
    REQUIRE(std::isfinite(z));
    largest = std::max(largest, static_cast<double>(std::abs(z)));
  }
  CHECK(largest > 0);
}

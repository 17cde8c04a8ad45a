#include <catch2/catch.hpp>
#include <random>

#include "mechanics/internal_forces.h"
#include "support/kernel_forces.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("A linear displacement field gives a uniform F", "[internal_forces]") {
  const TestBody body(5, 0.1, 4);
  Mat3 F;
  F << 1.1, 0.2, 0, -0.1, 0.8, 0.05, 0.3, 0, 1.2;
  const auto u = body.displacement(F);
  double worst = 0;
  for (int q = 0; q < body.shape.rowCount(); ++q)
    worst = std::max(worst, (deformationGradient(body.shape, q, u) - F).norm());
  CHECK(worst < 1e-10);  // linear consistency of MMLS, some hundred roundings times |gradN| R
}

TEST_CASE("Internal forces are minus the derivative of the strain energy", "[internal_forces]") {
  for (const auto& material : {Material::neoHookean(3000, 0.49, 1000), ogden()}) {
    const TestBody body(4, 0.1, 1, 1.8, 0.1, 0.2, material);
    for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
      auto u = wave(body, 0.2);
      const auto f = referenceForces(body, u, patches);
      const auto energy = [&] {
        return strainEnergy(body.shape, body.volume, body.point_material, body.materials, u, patches);
      };
      const double e = 1e-7;
      for (const int i : {0, 13, 21, 42, 63})
        for (int c = 0; c < 3; ++c) {
          u[i][c] += e;
          const double ahead = energy();
          u[i][c] -= 2 * e;
          const double behind = energy();
          u[i][c] += e;
          CHECK(-(ahead - behind) / (2 * e) == Approx(f[i][c]).epsilon(1e-5).margin(1e-6 * norm(f)));
        }
    }
  }
}

TEST_CASE("The fast kernel equals the reference in double", "[internal_forces][kernel]") {
  for (const auto& material :
       {Material::neoHookean(3000, 0.49, 1000), Material::neoHookean(3000, 0.499, 1000), ogden()})
    for (const int points : {1, 4}) {
      const TestBody body(6, 0.1, points, 1.8, 0.1, 0.2, material);
      for (const NodePatches& patches : {NodePatches{}, body.patches()})
        for (const auto& u : hardStates(body)) {
          ForceReport report;
          const auto fast = fastForces(body, u, 1, &report, patches), exact = referenceForces(body, u, patches);
          // Gradients rounded to float move J by 6e-8 |gradN| |u| n^(1/2) ~ 1e-6, which the bulk modulus
          // multiplies against forces of the order of the shear modulus: (K / mu) 1e-6.
          const double ratio = material.bulk_modulus / material.shear_modulus;
          INFO("relative error " << distance(fast, exact) / norm(exact) << " at K/mu " << ratio);
          CHECK(distance(fast, exact) < 1e-6 * ratio * norm(exact));
          double min_J = 1e9;
          for (int q = 0; q < body.shape.rowCount(); ++q)
            min_J = std::min(min_J, deformationGradient(body.shape, q, u).determinant());
          CHECK(report.min_J == Approx(std::min(1.0, min_J)).epsilon(1e-4));
          CHECK(report.inverted_points == 0);
        }
    }
}

TEST_CASE("The kernel in double equals the reference to rounding, and the one in float follows",
          "[internal_forces][kernel]") {
  std::vector<Material> materials{Material::neoHookean(3000, 0.49, 1000), Material::neoHookean(3000, 0.499, 1000),
                                  ogden()};
  for (std::size_t k = materials.size(); k-- > 0;) {
    materials.push_back(materials[k]);
    materials.back().barrier_strength = 2;
  }
  for (const auto& material : materials)
    for (const int points : {1, 4}) {
      const TestBody body(5, 0.1, points, 1.8, 0.1, 0.2, material);
      auto states = hardStates(body);
      states.push_back(body.displacement(Vec3(0.9, 1.0, 0.35).asDiagonal()));  // J 0.315: within the barrier
      for (const NodePatches& patches : {NodePatches{}, body.patches()})
        for (const auto& u : states) {
          ForceReport report;
          const auto fast = fastForces<double>(body, u, 1, &report, patches), exact = referenceForces(body, u, patches);
          const double ratio = material.bulk_modulus / material.shear_modulus,
                       error = distance(fast, exact) / norm(exact);
          INFO("relative error " << error << " at K/mu " << ratio << " barrier " << material.barrier_strength);
          CHECK(error < 1e-12);
          CHECK(distance(fastForces<float>(body, u, 1, nullptr, patches), fast) <
                1e-6 * ratio * norm(exact));  // as above
          double min_J = 1;
          for (int q = 0; q < body.shape.rowCount(); ++q)
            min_J = std::min(min_J, deformationGradient(body.shape, q, u).determinant());
          CHECK(report.min_J == Approx(min_J).epsilon(1e-6));  // the report is float
        }
    }
}

TEST_CASE("In double a rigid motion's forces are rounding, and more threads change no bit",
          "[internal_forces][kernel][determinism]") {
  const TestBody body(6, 0.1, 4);
  for (const double angle : {0.7, M_PI / 2}) {
    auto rigid = body.displacement(Eigen::AngleAxisd(angle, Vec3(1, 1, 0).normalized()).toRotationMatrix());
    for (auto& a : rigid) a += Vec3(0.05, -0.02, 0.01);
    const auto strained = fastForces<double>(body, wave(body, 0.3));
    for (const NodePatches& patches : {NodePatches{}, body.patches()})
      CHECK(norm(fastForces<double>(body, rigid, 1, nullptr, patches)) <
            1e-12 * norm(strained));  // K/mu times rounding
  }
  const auto u = wave(body, 0.3);
  const auto patches = body.patches();
  const auto one = fastForces<double>(body, u, 1, nullptr, patches);
  for (const int threads : {2, 3}) CHECK(fastForces<double>(body, u, threads, nullptr, patches) == one);
}

TEST_CASE("Rigid motion makes no force, and forces always sum to zero", "[internal_forces][kernel]") {
  const TestBody body(6, 0.1, 4);
  const Mat3 R = Eigen::AngleAxisd(0.7, Vec3(1, 1, 0).normalized()).toRotationMatrix();
  auto u = body.displacement(R);
  for (auto& a : u) a += Vec3(0.05, -0.02, 0.01);
  CHECK(norm(referenceForces(body, u)) < 1e-10);
  const auto strained = referenceForces(body, wave(body, 0.3));
  CHECK(norm(fastForces(body, u)) < 1e-4 * norm(strained));  // float: K/mu * 1e-6 of a working force

  Vec3 sum = Vec3::Zero();
  for (const auto& a : strained) sum += a;
  CHECK(sum.norm() < 1e-12 * norm(strained) * body.nodeCount());
}

TEST_CASE("Forces are the same bits for any number of threads", "[internal_forces][kernel][determinism]") {
  const TestBody body(6, 0.1, 4);
  const auto u = wave(body, 0.3);
  const auto one = fastForces(body, u, 1);
  for (const int threads : {2, 3, 4}) CHECK(fastForces(body, u, threads) == one);
  const auto patches = body.patches();
  const auto patched = fastForces(body, u, 1, nullptr, patches);
  CHECK(patched != one);
  for (const int threads : {2, 3, 4}) CHECK(fastForces(body, u, threads, nullptr, patches) == patched);
}

TEST_CASE("Two materials in one body each act on their own points", "[internal_forces][kernel]") {
  TestBody body(5, 0.1, 4);
  body.materials.push_back(ogden());
  body.materials.push_back(Material::neoHookean(30, 0.45, 1000));
  for (std::size_t q = 0; q < body.point_material.size(); ++q) body.point_material[q] = static_cast<int>(q % 7 % 3);
  const auto u = wave(body, 0.2);
  for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
    const auto exact = referenceForces(body, u, patches);
    CHECK(distance(fastForces(body, u, 1, nullptr, patches), exact) < 1e-4 * norm(exact));
  }
}

TEST_CASE("An inverted point is counted and named", "[internal_forces][kernel]") {
  TestBody body(5, 0.1, 1);
  auto u = body.displacement(Mat3::Identity());
  u[62] += Vec3(0.2, 0, 0);  // a node thrown over its neighbours
  ForceReport report;
  const auto f = fastForces(body, u, 1, &report);
  int expected = 0;
  double min_J = 1;
  int worst = -1;
  for (int q = 0; q < body.shape.rowCount(); ++q) {
    const double J = deformationGradient(body.shape, q, u).determinant();
    expected += J <= 0 ? 1 : 0;
    if (J < min_J) {
      min_J = J;
      worst = q;
    }
  }
  REQUIRE(expected > 0);
  CHECK(report.inverted_points == expected);
  CHECK(report.worst_point == worst);
  for (const auto& a : f) CHECK(a.allFinite());
}

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include "mechanics/critical_time_step.h"
#include "support/kernel_forces.h"

using namespace palpate;
using test::TestBody;

namespace {

/// Central differences from a random start: the largest displacement after `steps`.
double growth(const TestBody& body, double dt, int steps) {
  std::vector<Vec3> u(body.X.size(), Vec3::Zero()), du(body.X.size()), f;
  for (std::size_t i = 0; i < u.size(); ++i)
    du[i] = 1e-9 * Vec3(std::sin(12.3 * static_cast<double>(i)), std::sin(7.7 * static_cast<double>(i)),
                        std::cos(3.1 * static_cast<double>(i)));
  for (int s = 0; s < steps; ++s) {
    referenceInternalForces(body.shape, body.volume, body.point_material, body.materials, u, f);
    for (std::size_t i = 0; i < u.size(); ++i) {
      du[i] += dt * dt / body.mass[i] * f[i];
      u[i] += du[i];
    }
  }
  double largest = 0;
  for (const auto& a : du) {
    if (!a.allFinite()) return 1e300;
    largest = std::max(largest, a.norm());
  }
  return largest;
}

}  // namespace

TEST_CASE("The critical step is where central differences turn unstable", "[critical_time_step][whole]") {
  for (const double nu : {0.3, 0.49}) {
    const TestBody body(4, 0.1, 4, 1.8, 0.1, 0.2, Material::neoHookean(3000, nu, 1000));
    const auto limit = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass);
    INFO("critical " << limit.dt << " proven " << limit.dt_proven << " after " << limit.iterations);
    CHECK(limit.dt_proven < limit.dt);
    CHECK(limit.dt_proven > 0.2 * limit.dt);
    CHECK(growth(body, 0.98 * limit.dt, 400) < 1e-5);
    CHECK(growth(body, 1.03 * limit.dt, 400) > 1e-3);
  }
}

TEST_CASE("Node patches only lengthen the stable step", "[critical_time_step]") {
  for (const int points : {1, 4}) {
    const TestBody body(5, 0.1, points);
    const auto plain = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass);
    const auto patched =
        criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass, body.patches());
    CHECK(patched.dt > plain.dt);
    CHECK(patched.dt < 2 * plain.dt);
    CHECK(patched.dt_proven == plain.dt_proven);
  }
}

TEST_CASE("Lanczos finds the largest eigenvalue of a small body", "[critical_time_step]") {
  const TestBody body(4, 0.1, 1);
  const auto limit = criticalTimeStep(body.shape, body.volume, body.point_material, body.materials, body.mass);
  // Stiffness by differentiating the forces, dense eigenvalues.
  Eigen::MatrixXd K = test::stiffnessByDifferences(body);
  for (int r = 0; r < K.rows(); ++r)
    for (int c = 0; c < K.cols(); ++c) K(r, c) /= std::sqrt(body.mass[r / 3] * body.mass[c / 3]);
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues().maxCoeff();
  const double exact = 2 / std::sqrt(largest);
  CHECK(limit.dt <= exact * (1 + 1e-6));  // never optimistic
  CHECK(limit.dt > 0.99 * exact);
}

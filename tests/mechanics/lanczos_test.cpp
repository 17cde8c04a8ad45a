#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "mechanics/critical_time_step.h"
#include "mechanics/lanczos.h"
#include "support/kernel_forces.h"

using namespace palpate;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

namespace {

LargestEigenvalue largestOf(const Matrix& A, int iterations, double tolerance) {
  return largestEigenvalue(
      A.rows(), [&](const Vector& x, Vector& y) { y = A * x; }, iterations, tolerance);
}

/// A symmetric matrix with these eigenvalues and a rotation of no special directions.
Matrix withSpectrum(const Vector& eigenvalues) {
  const Eigen::Index n = eigenvalues.size();
  Matrix Q(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      Q(i, j) = std::sin(1.0 + 3.7 * static_cast<double>(i) + 11.3 * static_cast<double>(j * j));
  Q = Q.householderQr().householderQ();
  return Q * eigenvalues.asDiagonal() * Q.transpose();
}

}  // namespace

TEST_CASE("Lanczos finds the largest eigenvalue of known matrices", "[lanczos]") {
  const Vector spread = Vector::LinSpaced(60, 1, 60);
  const auto known = largestOf(withSpectrum(spread), 60, 1e-10);
  CHECK(known.value == Approx(60).epsilon(1e-10));
  Vector pair = Vector::LinSpaced(40, 0, 1);  // a double largest one, far above the rest
  pair[0] = pair[1] = 7;
  const auto twofold = largestOf(withSpectrum(pair), 40, 1e-12);
  CHECK(twofold.value == Approx(7).epsilon(1e-12));
  CHECK(twofold.iterations < 25);                    // well separated: it stops by its residual
  Vector negative = Vector::LinSpaced(30, -100, 5);  // the largest, not that of the largest modulus
  CHECK(largestOf(withSpectrum(negative), 30, 1e-10).value == Approx(5).epsilon(1e-9));
}

TEST_CASE("Lanczos' residual holds an eigenvalue, however few the iterations", "[lanczos]") {
  const Vector spectrum = Vector::LinSpaced(80, 1, 100).array().sqrt();
  const Matrix A = withSpectrum(spectrum);
  for (int iterations = 1; iterations <= 80; iterations *= 2) {
    const auto r = largestOf(A, iterations, 0);
    CHECK(r.iterations == iterations);
    CHECK(r.value <= 10 * (1 + 1e-12));  // a Rayleigh quotient never exceeds the largest
    CHECK((spectrum.array() - r.value).abs().minCoeff() <= r.residual + 1e-12);
  }
}

TEST_CASE("Lanczos ends at once where the first vector is an eigenvector", "[lanczos]") {
  const auto one = largestOf(Matrix::Constant(1, 1, 3.5), 50, 1e-9);
  CHECK(one.value == Approx(3.5));
  CHECK(one.iterations == 1);
  const auto multiple = largestOf(2 * Matrix::Identity(20, 20), 50, 1e-9);
  CHECK(multiple.value == Approx(2));
  CHECK(multiple.iterations == 1);
}

TEST_CASE("Gershgorin rows of one point are its weight times the gradients' norms", "[critical_time_step]") {
  ShapeTable shape;
  shape.begin = {0, 3};
  shape.node = {0, 2, 3};
  shape.N = {0.5, 0.25, 0.25};
  shape.gradN = {Vec3(3, 0, 4), Vec3(0, -2, 0), Vec3(-3, 2, -4)};
  const Material m = Material::neoHookean(3000, 0.4, 1000);
  const double volume = 2e-6, weight = volume * m.waveModulus() * (5 + 2 + std::sqrt(29.0));
  const auto rows = gershgorinRows(shape, {volume}, {0}, {m}, 4);
  REQUIRE(rows.size() == 4);
  CHECK(rows[0] == Approx(weight * 5));
  CHECK(rows[1] == 0);
  CHECK(rows[2] == Approx(weight * 2));
  CHECK(rows[3] == Approx(weight * std::sqrt(29.0)));
  // A negative volume (of the 5-point rule) stiffens as its modulus at most.
  CHECK(gershgorinRows(shape, {-volume}, {0}, {m}, 4) == rows);
}

TEST_CASE("Gershgorin rows bound the frequencies with any masses - as masses they make all of them below 1",
          "[critical_time_step]") {
  for (const int points : {1, 4}) {
    const test::TestBody body(3, 0.1, points);
    const auto rows = gershgorinRows(body.shape, body.volume, body.point_material, body.materials, body.X.size());
    for (const NodePatches& patches : {NodePatches{}, body.patches()}) {
      const Matrix K = test::stiffnessByDifferences(body, patches);
      const auto largest = [&](const std::vector<double>& mass) {
        Matrix A = K;
        for (Eigen::Index r = 0; r < A.rows(); ++r)
          for (Eigen::Index c = 0; c < A.cols(); ++c)
            A(r, c) /= std::sqrt(mass[static_cast<std::size_t>(r / 3)] * mass[static_cast<std::size_t>(c / 3)]);
        return Eigen::SelfAdjointEigenSolver<Matrix>(A).eigenvalues().maxCoeff();
      };
      std::vector<double> uneven = body.mass;
      for (std::size_t i = 0; i < uneven.size(); ++i) uneven[i] *= 1 + 0.9 * std::sin(5.0 * static_cast<double>(i));
      for (const auto& mass : {body.mass, uneven}) {
        double bound = 0;
        for (std::size_t i = 0; i < mass.size(); ++i) bound = std::max(bound, rows[i] / mass[i]);
        CHECK(largest(mass) <= bound);
        CHECK(largest(mass) > 0.02 * bound);  // of use
      }
      CHECK(largest(rows) <= 1);
      CHECK(largest(rows) > 0.05);
    }
  }
}

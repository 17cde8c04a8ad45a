#include <catch2/catch.hpp>

#include <Eigen/LU>

#include <cmath>

#include "base/input_error.h"
#include "discretization/cells/integration_points.h"

using namespace palpate;

namespace {

// One general tetrahedron; the integral of x^i y^j z^k over it follows from barycentric moments.
const std::vector<Vec3> vertices = {{0.1, -0.2, 0.3}, {1.3, 0.2, 0.1}, {0.4, 1.1, -0.2}, {0.2, 0.3, 1.7}};
const std::vector<std::array<int, 4>> one_cell = {{0, 1, 2, 3}};

double cellVolume() {
  Mat3 edges;
  edges << vertices[1] - vertices[0], vertices[2] - vertices[0], vertices[3] - vertices[0];
  return edges.determinant() / 6;
}

/// Closed form: int x_r x_s dV = V/20 (sum_a x_ra x_sa + sum_a x_ra sum_b x_sb).
Mat3 secondMoments() {
  Vec3 sum = Vec3::Zero();
  Mat3 squares = Mat3::Zero();
  for (const Vec3& x : vertices) {
    sum += x;
    squares += x * x.transpose();
  }
  return cellVolume() / 20 * (squares + sum * sum.transpose());
}

Mat3 secondMoments(const IntegrationPoints& points) {
  Mat3 moments = Mat3::Zero();
  for (std::size_t q = 0; q < points.X.size(); ++q) {
    moments += points.volume[q] * points.X[q] * points.X[q].transpose();
  }
  return moments;
}

Vec3 firstMoment(const IntegrationPoints& points) {
  Vec3 moment = Vec3::Zero();
  for (std::size_t q = 0; q < points.X.size(); ++q) moment += points.volume[q] * points.X[q];
  return moment;
}

}  // namespace

TEST_CASE("Four points integrate all quadratics exactly, one point all linear functions", "[quadrature]") {
  const double volume = cellVolume();
  const Vec3 first = volume * (vertices[0] + vertices[1] + vertices[2] + vertices[3]) / 4;
  const IntegrationPoints one = makeIntegrationPoints(vertices, one_cell, {volume}, 1);
  const IntegrationPoints four = makeIntegrationPoints(vertices, one_cell, {volume}, 4);
  REQUIRE(one.X.size() == 1);
  REQUIRE(four.X.size() == 4);
  CHECK((firstMoment(one) - first).norm() < 1e-15);  // a few roundings of numbers of order 0.1
  CHECK((firstMoment(four) - first).norm() < 1e-15);
  CHECK((secondMoments(four) - secondMoments()).norm() < 1e-15);
  CHECK((secondMoments(one) - secondMoments()).norm() > 1e-3);  // and one point does not
}

TEST_CASE("Each rule is exact to its degree and not beyond", "[quadrature]") {
  // Barycentric monomials: int l0^a l1^b l2^c l3^d dV = 6 V a! b! c! d! / (a + b + c + d + 3)!
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  Mat3 edges;
  edges << vertices[1] - vertices[0], vertices[2] - vertices[0], vertices[3] - vertices[0];
  for (const auto& [per_cell, degree] : {std::pair{1, 1}, {4, 2}, {5, 3}}) {
    const IntegrationPoints points = makeIntegrationPoints(vertices, one_cell, {1.0}, per_cell);
    double worst_within = 0, worst_beyond = 0;
    for (int code = 0; code < 625; ++code) {
      const int power[4] = {code % 5, code / 5 % 5, code / 25 % 5, code / 125};
      const int total = power[0] + power[1] + power[2] + power[3];
      if (total > degree + 1) continue;
      double exact = 6 / factorial(total + 3), sum = 0;
      for (int p : power) exact *= factorial(p);
      for (std::size_t q = 0; q < points.X.size(); ++q) {
        const Vec3 l = edges.inverse() * (points.X[q] - vertices[0]);
        const double bary[4] = {1 - l.sum(), l[0], l[1], l[2]};
        double value = points.volume[q];
        for (int k = 0; k < 4; ++k) value *= std::pow(bary[k], power[k]);
        sum += value;
      }
      double& worst = total <= degree ? worst_within : worst_beyond;
      worst = std::max(worst, std::abs(sum - exact));
    }
    INFO(per_cell << " points");
    CHECK(worst_within < 1e-15);  // a few roundings of numbers below 1
    CHECK(worst_beyond > 1e-4);
  }
}

TEST_CASE("Points' volumes of a cell sum to the cell's, bit for bit", "[quadrature]") {
  const std::vector<std::array<int, 4>> cells = {{0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 3}};
  const std::vector<double> volume = {0.1, 1e-9 / 3, 7.7};
  for (int per_cell : {1, 4}) {
    const IntegrationPoints points = makeIntegrationPoints(vertices, cells, volume, per_cell);
    std::vector<double> sum(3, 0.0);
    for (std::size_t q = 0; q < points.X.size(); ++q) {
      REQUIRE(points.cell[q] == static_cast<int>(q) / per_cell);
      sum[points.cell[q]] += points.volume[q];
    }
    CHECK(sum == volume);
  }
}

TEST_CASE("With five points the volumes sum to the cell's in spite of the negative one", "[quadrature]") {
  for (double volume : {0.1, 1e-9 / 3, 7.7, 1e-20}) {
    const IntegrationPoints points = makeIntegrationPoints(vertices, one_cell, {volume}, 5);
    REQUIRE(points.X.size() == 5);
    CHECK((points.X[0] - (vertices[0] + vertices[1] + vertices[2] + vertices[3]) / 4).norm() < 1e-15);
    CHECK(points.volume[0] == Approx(-0.8 * volume));
    double sum = 0;
    for (double v : points.volume) sum += v;
    CHECK(std::abs(sum - volume) < 1e-15 * volume);  // four roundings of sums below 1.8 volume
  }
}

TEST_CASE("A rule that does not exist is refused", "[quadrature][input]") {
  for (int per_cell : {-1, 0, 2, 3, 6}) {
    CHECK_THROWS_AS(makeIntegrationPoints(vertices, one_cell, {1.0}, per_cell), InputError);
  }
}

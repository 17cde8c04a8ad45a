#include <catch2/catch.hpp>

#include <Eigen/LU>

#include <numeric>

#include "base/input_error.h"
#include "discretization/integration_points.h"

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

TEST_CASE("A rule that does not exist is refused", "[quadrature][input]") {
  for (int per_cell : {-1, 0, 2, 5}) {
    CHECK_THROWS_AS(makeIntegrationPoints(vertices, one_cell, {1.0}, per_cell), InputError);
  }
}

#include <catch2/catch.hpp>
#include <cmath>

#include "discretization/cells/background_cells.h"
#include "discretization/gradients/consistent_gradients.h"
#include "discretization/surface/facet_rule.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

TestBody orientedBody(int points) {
  TestBody body(6, 0.1, points);
  for (auto& cell : body.cells) {  // the lattice's cells come in both orientations
    const Vec3 a = body.X[cell[1]] - body.X[cell[0]], b = body.X[cell[2]] - body.X[cell[0]],
               c = body.X[cell[3]] - body.X[cell[0]];
    if (a.cross(b).dot(c) < 0) std::swap(cell[2], cell[3]);
  }
  return body;
}

ShapeTable shapesAt(const TestBody& body, const std::vector<Vec3>& at) {
  const Neighbours neighbours(body.X, body.radius);
  std::vector<InadmissibleSupport> failed;
  ShapeTable table = shapeFunctions(at, body.X, body.radius, neighbours, {2, 0.1}, failed);
  REQUIRE(failed.empty());
  return table;
}

/// Base and top, as in a body that is held and pulled.
std::vector<std::uint8_t> baseAndTop(const TestBody& body) {
  std::vector<std::uint8_t> imposed;
  for (const auto& x : body.X) imposed.push_back(x.z() < 1e-9 || x.z() > 0.1 - 1e-9 ? 7 : 0);
  return imposed;
}

}  // namespace

TEST_CASE("The facet rule integrates polynomials of degree 4", "[consistent_gradients]") {
  // Over the unit triangle: int x^a y^b = a! b! / (a + b + 2)!
  const double factorial[] = {1, 1, 2, 6, 24, 120, 720};
  for (int a = 0; a <= 4; ++a)
    for (int b = 0; a + b <= 4; ++b) {
      double sum = 0;
      for (int k = 0; k < FacetRule::size; ++k) {
        const Vec3 x = FacetRule::point(k, Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY());
        sum += FacetRule::weight(k) / 2 * std::pow(x[0], a) * std::pow(x[1], b);
      }
      CHECK(sum == Approx(factorial[a] * factorial[b] / factorial[a + b + 2]).epsilon(1e-13));
    }
}

TEST_CASE("Boundary samples: closed surface, right volume, nodes' rule on imposed facets only",
          "[consistent_gradients]") {
  const TestBody body = orientedBody(1);
  const auto facets = boundaryFacets(body.cells);
  const auto imposed = baseAndTop(body);
  const auto samples = boundaryPoints(body.X, facets, imposed);
  Vec3 sum = Vec3::Zero();
  double volume = 0, base = 0, inside_base = 0;
  for (std::size_t k = 0; k < samples.X.size(); ++k) {
    sum += samples.area[k];
    volume += samples.X[k].dot(samples.area[k]) / 3;
    if (samples.X[k].z() > 1e-12) continue;
    base -= samples.area[k].z();
    double nearest = 1;
    for (const auto& x : body.X) nearest = std::min(nearest, (x - samples.X[k]).norm());
    if (nearest > 1e-12) inside_base -= samples.area[k].z();
    CHECK((samples.node[k] >= 0) == (nearest <= 1e-12));
  }
  CHECK(sum.norm() < 1e-15);
  CHECK(volume == Approx(1e-3).epsilon(1e-12));
  CHECK(base == Approx(1e-2).epsilon(1e-12));
  CHECK(inside_base == 0);
  // 2 x 36 nodes of base and top, 6 samples of each of the 4 x 50 facets on the sides, and of the 2 x 50 held ones.
  CHECK(samples.X.size() == 72 + 1200 + 600);
}

TEST_CASE("Areas of held nodes integrate shape functions, and keep forces and moments", "[consistent_gradients]") {
  const TestBody body = orientedBody(1);
  const auto facets = boundaryFacets(body.cells);
  BoundaryPoints thirds = boundaryPoints(body.X, facets, baseAndTop(body));
  const ShapeTable shape = shapesAt(body, thirds.X);
  BoundaryPoints balanced = thirds;
  balanceNodes(balanced, shape);
  // How far the nodes' sums are from those of 6 points a facet, and the base's second moment over its own, a^4 / 12.
  const auto off = [&](const BoundaryPoints& samples) {
    std::vector<double> lacks(body.X.size(), 0);
    double sum = 0, moment = 0;
    for (std::size_t k = 0; k < samples.X.size(); ++k) {
      const double nodes = samples.node[k] >= 0 ? samples.area[k].z() : 0;
      for (int e = shape.begin[k]; e < shape.begin[k + 1]; ++e)
        lacks[shape.node[e]] += (samples.of_held[k].z() - nodes) * shape.N[e];
      if (samples.X[k].z() < 1e-9) moment -= nodes * std::pow(samples.X[k].x() - 0.05, 2);
    }
    for (const double lack : lacks) sum += lack * lack;
    return std::pair{std::sqrt(sum), moment / (1e-4 / 12)};
  };
  INFO("thirds " << off(thirds).first << ", " << off(thirds).second << ", balanced " << off(balanced).first << ", "
                 << off(balanced).second);
  CHECK(off(balanced).first < 0.5 * off(thirds).first);
  CHECK(off(thirds).second == Approx(1.08).epsilon(0.01));  // 1 + 2 / 5^2
  CHECK(off(balanced).second < 1.04);
  Vec3 force = Vec3::Zero();
  Mat3 moment = Mat3::Zero();
  for (std::size_t k = 0; k < thirds.X.size(); ++k) {
    force += balanced.area[k] - thirds.area[k];
    moment += balanced.X[k] * (balanced.area[k] - thirds.area[k]).transpose();
  }
  CHECK(force.norm() < 1e-15);
  CHECK(moment.norm() < 1e-16);

  // Faces that are held in other components than they face, or bear loads beside, keep thirds.
  const std::vector<std::uint8_t> slides(body.X.size(), 3);
  for (const bool loaded : {false, true}) {
    const BoundaryPoints kept = boundaryPoints(body.X, facets, slides, loaded);
    for (std::size_t k = 0; k < kept.X.size(); ++k)
      if (kept.face[k] >= 0) CHECK(std::abs(kept.area[k].z()) + loaded == 0);
  }
}

TEST_CASE("A held facet alone keeps its thirds", "[consistent_gradients]") {
  const TestBody body = orientedBody(1);
  const auto facets = boundaryFacets(body.cells);
  for (std::size_t f = 0; f < facets.size(); f += 6) {
    std::vector<std::uint8_t> imposed(body.X.size(), 0);
    for (const int i : facets[f]) imposed[i] = 7;
    const BoundaryPoints thirds = boundaryPoints(body.X, facets, imposed);
    BoundaryPoints balanced = thirds;
    balanceNodes(balanced, shapesAt(body, thirds.X));
    CHECK(balanced.area == thirds.area);
  }
}

TEST_CASE("Corrected gradients satisfy the divergence theorem and stay linearly consistent", "[consistent_gradients]") {
  for (const int points : {1, 4}) {
    TestBody body = orientedBody(points);
    const ShapeTable before = body.shape;
    const auto boundary = boundaryPoints(body.X, boundaryFacets(body.cells), baseAndTop(body));
    const auto result =
        correctGradients(body.shape, body.point_X, body.volume, body.X, boundary, shapesAt(body, boundary.X), 1e-8);
    INFO(points << " points: violation " << result.violation_before << " -> " << result.violation_after << " in "
                << result.iterations);
    CHECK(result.violation_before > 1e-3);
    CHECK(result.violation_after < 1e-7 * 1.1 + 1e-8 * result.violation_before);

    double worst = 0, change = 0, size = 0;
    for (int q = 0; q < body.shape.rowCount(); ++q) {
      Vec3 sum = Vec3::Zero();
      Mat3 linear = -Mat3::Identity();
      for (int e = body.shape.begin[q]; e < body.shape.begin[q + 1]; ++e) {
        sum += body.shape.gradN[e];
        linear += body.X[body.shape.node[e]] * body.shape.gradN[e].transpose();
        change += (body.shape.gradN[e] - before.gradN[e]).squaredNorm();
        size += before.gradN[e].squaredNorm();
      }
      worst = std::max({worst, sum.norm() * 0.02, linear.norm()});
    }
    CHECK(worst < 1e-9);
    CHECK(change < 0.05 * size);  // a correction, not another approximation
  }
}

TEST_CASE("The 6-point rule finds less to correct than the nodes' rule", "[consistent_gradients]") {
  // The violation is then the quadrature error of the cells, not that of the facets too.
  const auto violation = [](bool all_imposed) {
    TestBody body = orientedBody(4);
    const std::vector<std::uint8_t> imposed(body.X.size(), all_imposed);
    const auto boundary = boundaryPoints(body.X, boundaryFacets(body.cells), imposed);
    return correctGradients(body.shape, body.point_X, body.volume, body.X, boundary, shapesAt(body, boundary.X))
        .violation_before;
  };
  const double six = violation(false), nodes = violation(true);
  INFO("6 points " << six << ", nodes " << nodes);
  CHECK(six < 0.5 * nodes);
}

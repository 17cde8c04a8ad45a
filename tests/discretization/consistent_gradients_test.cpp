#include <catch2/catch.hpp>

#include "discretization/background_cells.h"
#include "discretization/consistent_gradients.h"
#include "support/test_body.h"

using namespace palpate;
using test::TestBody;

namespace {

ShapeTable atNodes(const TestBody& body) {
  const Neighbours neighbours(body.X, body.radius);
  std::vector<InadmissibleSupport> failed;
  ShapeTable table = shapeFunctions(body.X, body.X, body.radius, neighbours, {2, 0.1}, failed);
  REQUIRE(failed.empty());
  return table;
}

}  // namespace

TEST_CASE("Corrected gradients satisfy the divergence theorem and stay linearly consistent", "[consistent_gradients]") {
  for (const int points : {1, 4}) {
    TestBody body(6, 0.1, points);
    for (auto& cell : body.cells) {  // the lattice's cells come in both orientations
      const Vec3 a = body.X[cell[1]] - body.X[cell[0]], b = body.X[cell[2]] - body.X[cell[0]], c = body.X[cell[3]] - body.X[cell[0]];
      if (a.cross(b).dot(c) < 0) std::swap(cell[2], cell[3]);
    }
    const ShapeTable before = body.shape;
    const auto result = correctGradients(body.shape, body.point_X, body.volume, body.X, boundaryFacets(body.cells), atNodes(body), 1e-8);
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

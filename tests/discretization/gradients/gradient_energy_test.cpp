#include "discretization/gradients/gradient_energy.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstdio>
#include <limits>

#include "base/input_error.h"
#include "discretization/cells/adaptive_quadrature.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cells/cell_division.h"
#include "discretization/surface/solids.h"

using namespace palpate;

namespace {

/// The 100 mm cube of section 3.1, which has 260 nodes at a spacing of about 21 mm.
struct Cube {
  NodeCloud cloud;
  BackgroundCells cells;
  std::vector<double> radius;
  explicit Cube(double h) {
    const SurfaceTree surface(boxSurface(Vec3(0.1, 0.1, 0.1), 0.01));
    SpacingField spacing;
    spacing.spacing = h;
    cloud = makeNodeCloud(surface, spacing, 1);
    cells = makeBackgroundCells(cloud, surface);
    radius.assign(cloud.X.size(), 1.8 * 1.04 * spacing.spacing);  // R/h 1.8; the mean edge is 1.04 of the spacing
  }

  /// Integrals of eq. 30 over the cells.
  std::vector<Vec3> integrate(GradientEnergy f, const IntegrationPoints& points) const {
    std::vector<Vec3> sum(cells.cells.size(), Vec3::Zero());
    for (std::size_t q = 0; q < points.X.size(); ++q) sum[points.cell[q]] += points.volume[q] * f(points.X[q]);
    return sum;
  }
  /// The same by 4 points in each of 64 parts of a cell.
  std::vector<Vec3> reference(const GradientEnergy& f) const {
    IntegrationPoints fine;
    std::array<Corners, 8> parts, small;
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
      const auto& [i, j, k, l] = cells.cells[c];
      divideCell({cloud.X[i], cloud.X[j], cloud.X[k], cloud.X[l]}, 8, 0, parts);
      for (const Corners& part : parts) {
        divideCell(part, 8, 1, small);
        for (const Corners& corners : small)
          cellRule(4).append(corners, cells.volume[c] / 64, static_cast<int>(c), fine);
      }
    }
    return integrate(f, fine);
  }
};

/// Sum of the cells' errors over the whole integral.
double cellError(const std::vector<Vec3>& sum, const std::vector<Vec3>& reference) {
  double error = 0, total = 0;
  for (std::size_t c = 0; c < sum.size(); ++c) {
    error += (sum[c] - reference[c]).cwiseAbs().sum();
    total += reference[c].sum();
  }
  return error / total;
}

}  // namespace

TEST_CASE("Gradient energy is the sum of squared gradients, and not finite on a bad support", "[quadrature][mmls]") {
  const Cube cube(0.03);
  const Neighbours neighbours(cube.cloud.X, cube.radius);
  GradientEnergy energy(cube.cloud.X, cube.radius, neighbours, {2, 0.1});
  const auto points = makeIntegrationPoints(cube.cloud.X, cube.cells.cells, cube.cells.volume, 1);
  std::vector<InadmissibleSupport> failed;
  const ShapeTable shape = shapeFunctions(points.X, cube.cloud.X, cube.radius, neighbours, {2, 0.1}, failed);
  REQUIRE(failed.empty());
  for (int q = 0; q < shape.rowCount(); ++q) {
    Vec3 sum = Vec3::Zero();
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) sum += shape.gradN[e].cwiseProduct(shape.gradN[e]);
    REQUIRE((energy(points.X[q]) - sum).norm() < 1e-12 * sum.norm());
  }
  CHECK_FALSE(energy(Vec3(1, 1, 1)).allFinite());  // far outside: no support
}

TEST_CASE("Supports too small to judge by are told, and grow until they can", "[quadrature][mmls]") {
  Cube cube(0.03);
  for (double& r : cube.radius) r *= 0.6;
  int rounds = 0;
  for (;; ++rounds) {
    REQUIRE(rounds < 20);
    const Neighbours neighbours(cube.cloud.X, cube.radius);
    const GradientEnergy energy(cube.cloud.X, cube.radius, neighbours, {2, 0.1});
    const auto result =
        makeAdaptivePoints(cube.cloud.X, cube.cells.cells, cube.cells.volume, AdaptiveOptions{0.1, 4, 2, 1}, energy);
    if (result.not_finite.empty()) break;
    std::vector<InadmissibleSupport> failed(result.not_finite.size());
    for (std::size_t k = 0; k < failed.size(); ++k) failed[k].row = static_cast<int>(k);
    std::vector<double> larger = cube.radius;
    enlargeSupports(result.not_finite, failed, neighbours, larger);
    cube.radius = larger;
  }
  CHECK(rounds > 0);
}

TEST_CASE("The error of eq. 30 over the cells falls with the accuracy asked for", "[quadrature][mmls][whole]") {
  const Cube cube(0.03);
  const Neighbours neighbours(cube.cloud.X, cube.radius);
  const GradientEnergy energy(cube.cloud.X, cube.radius, neighbours, {2, 0.1});
  const auto reference = cube.reference(energy);
  double last_error = 1e9;
  std::size_t last_count = 0;
  for (double accuracy : {1e9, 0.02, 0.005}) {
    const auto result = makeAdaptivePoints(cube.cloud.X, cube.cells.cells, cube.cells.volume,
                                           AdaptiveOptions{accuracy, 4, 8, 4}, energy);
    REQUIRE(result.not_finite.empty());
    const double error = cellError(cube.integrate(energy, result.points), reference);
    INFO("accuracy " << accuracy << ": " << result.points.X.size() << " points, error " << error);
    CHECK(error < 0.6 * last_error);
    CHECK(error < accuracy);
    CHECK(result.points.X.size() > last_count);
    CHECK(result.limited_cells == 0);
    last_error = error;
    last_count = result.points.X.size();
  }
}

// What it costs. Run with: discretization_tests "[.table]"

TEST_CASE("Points against accuracy on the cube of section 3.1", "[.table]") {
  const Cube cube(0.0209);
  const Neighbours neighbours(cube.cloud.X, cube.radius);
  const GradientEnergy energy(cube.cloud.X, cube.radius, neighbours, {2, 0.1});
  const auto reference = cube.reference(energy);
  std::printf(
      "%zu nodes, %zu cells\nrule division  accuracy   points  divided deepest limited worst_error cell_error\n",
      cube.cloud.X.size(), cube.cells.cells.size());
  for (int per_cell : {1, 4, 5})
    for (int division : {2, 4, 8})
      for (double accuracy : {1e9, 0.1, 0.05, 0.01, 0.002}) {
        if (accuracy > 1 && division > 2) continue;                    // the plain rule
        if (accuracy < 0.01 && per_cell != 4) continue;                // many points
        const int depth = division == 2 ? 12 : division == 4 ? 6 : 4;  // to 1/4096 of a cell
        const auto result = makeAdaptivePoints(cube.cloud.X, cube.cells.cells, cube.cells.volume,
                                               AdaptiveOptions{accuracy, per_cell, division, depth}, energy);
        std::printf("%4d %8d %9.3g %8zu %8d %7d %7d %11.3g %10.3g\n", per_cell, division, accuracy,
                    result.points.X.size(), result.divided_cells, result.deepest, result.limited_cells,
                    result.worst_error, cellError(cube.integrate(energy, result.points), reference));
        std::fflush(stdout);
      }
}

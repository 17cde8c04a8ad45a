#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <random>

#include "base/input_error.h"
#include "discretization/cells/adaptive_quadrature.h"
#include "discretization/cells/cell_division.h"
#include "discretization/tetrahedra.h"
#include "support/test_body.h"

using namespace palpate;

namespace {

/// The unit cube in Kuhn's six tetrahedra around its diagonal, `n` cubes to an edge.
struct Grid {
  std::vector<Vec3> X;
  std::vector<std::array<int, 4>> cells;
  std::vector<double> volume;
  explicit Grid(int n) : cells(test::kuhnCells(n + 1)) {
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) X.emplace_back(Vec3(i, j, k) / n);
    for (std::size_t c = 0; c < cells.size(); ++c) volume.push_back(volumeOf(corners(c)));
  }
  Corners corners(std::size_t c) const { return {X[cells[c][0]], X[cells[c][1]], X[cells[c][2]], X[cells[c][3]]}; }
};

std::vector<double> cellSums(const IntegrationPoints& points, std::size_t cells) {
  std::vector<double> sum(cells, 0);
  for (std::size_t q = 0; q < points.X.size(); ++q) sum[points.cell[q]] += points.volume[q];
  return sum;
}

}  // namespace

TEST_CASE("Division in 4 refines towards every corner", "[quadrature]") {
  // All divided 8 times: each face had its turn twice. With one face for all, the cells at the opposite corner
  // would still reach from it to that face.
  const std::vector<Vec3> X(general.begin(), general.end());
  const double volume = volumeOf(general);
  const Integrand bent = [](const Vec3& x) -> Vec3 { return (x.array() * 0.3).exp(); };
  const auto result = makeAdaptivePoints(X, {{0, 1, 2, 3}}, {volume}, AdaptiveOptions{1e-300, 1, 4, 8}, bent);
  REQUIRE(result.points.X.size() == 65536);
  for (const Vec3& corner : X) {
    double nearest = 1e9;
    for (const Vec3& x : result.points.X) nearest = std::min(nearest, (x - corner).norm());
    CHECK(nearest < 0.12 * (centroid(general) - corner).norm());  // 1/16 with edges of the corner halved 4 times
  }
  // And where the trouble is in one corner, the points crowd there, whichever it is.
  for (const Vec3& corner : X) {
    const Integrand peak = [&](const Vec3& x) { return Vec3(1 / std::sqrt((x - corner).norm()), 1, 1); };
    const auto crowd = makeAdaptivePoints(X, {{0, 1, 2, 3}}, {volume}, AdaptiveOptions{1e-4, 4, 4, 7}, peak);
    const auto plain = makeIntegrationPoints(X, {{0, 1, 2, 3}}, {volume}, 4);
    const auto nearest = [&](const IntegrationPoints& points) {
      double d = 1e9;
      for (const Vec3& x : points.X) d = std::min(d, (x - corner).norm());
      return d;
    };
    CHECK(crowd.points.X.size() > 8);
    CHECK(nearest(crowd.points) < 0.3 * nearest(plain));
  }
}

TEST_CASE("What a rule integrates exactly divides no cell, what is a degree higher does", "[quadrature]") {
  const Grid grid(2);
  const auto power = [](int degree) {
    return [degree](const Vec3& x) -> Vec3 {
      const double a = 1 + x[0] + 0.5 * x[1] - 0.3 * x[2];
      return {std::pow(a, degree), std::pow(1 + x[1], degree), 1};
    };
  };
  for (const auto& [per_cell, degree] : {std::pair{1, 1}, {4, 2}, {5, 3}})
    for (int division : {2, 4, 8}) {
      INFO(per_cell << " points, division " << division);
      const auto exact = makeAdaptivePoints(grid.X, grid.cells, grid.volume,
                                            AdaptiveOptions{1e-13, per_cell, division, 2}, power(degree));
      CHECK(exact.divided_cells == 0);
      CHECK(exact.points.X.size() == grid.cells.size() * per_cell);
      CHECK(exact.worst_error < 1e-13);
      const auto higher = makeAdaptivePoints(grid.X, grid.cells, grid.volume,
                                             AdaptiveOptions{1e-13, per_cell, division, 2}, power(degree + 1));
      CHECK(higher.divided_cells == static_cast<int>(grid.cells.size()));
    }
}

TEST_CASE("Adaptive points stay exact for the rule's polynomials and keep the cells' volumes", "[quadrature]") {
  const Grid grid(2);
  // int (x + 2 y - z)^2 over the unit cube: variance (1 + 4 + 1)/12 plus mean 1 squared.
  const double exact = 0.5 + 1;
  const Integrand kinked = [](const Vec3& x) { return Vec3(std::abs(x[0] + 0.4 * x[1] - 0.6), 1, 1); };
  std::vector<double> scaled = grid.volume;  // volumes need not be those of the vertices
  for (std::size_t c = 0; c < scaled.size(); ++c) scaled[c] *= 1 + 0.01 * static_cast<double>(c % 7);
  for (int per_cell : {1, 4, 5})
    for (int division : {2, 4, 8}) {
      INFO(per_cell << " points, division " << division);
      const AdaptiveOptions o = AdaptiveOptions{1e-3, per_cell, division, 4};
      const auto result = makeAdaptivePoints(grid.X, grid.cells, grid.volume, o, kinked);
      REQUIRE(result.divided_cells > 0);
      double sum = 0, volume = 0;
      for (std::size_t q = 0; q < result.points.X.size(); ++q) {
        sum += result.points.volume[q] * std::pow(result.points.X[q].dot(Vec3(1, 2, -1)), per_cell == 1 ? 1 : 2);
        volume += result.points.volume[q];
      }
      CHECK(sum == Approx(per_cell == 1 ? 1 : exact).epsilon(1e-12));
      CHECK(volume == Approx(1).epsilon(1e-12));

      const auto of_scaled = makeAdaptivePoints(grid.X, grid.cells, scaled, o, kinked);
      CHECK(of_scaled.points.X == result.points.X);
      const auto sums = cellSums(of_scaled.points, grid.cells.size());
      for (std::size_t c = 0; c < sums.size(); ++c) CHECK(std::abs(sums[c] - scaled[c]) < 1e-12 * scaled[c]);
    }
}

TEST_CASE("A kink refines the cells that it crosses and no others", "[quadrature]") {
  const Grid grid(4);
  constexpr double kink = 0.37;
  const Integrand f = [](const Vec3& x) { return Vec3(1, std::abs(x[0] - kink) + 0.1, 1); };
  for (int division : {2, 4, 8}) {
    INFO("division " << division);
    const auto result = makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{0.003, 4, division, 6}, f);
    std::vector<int> count(grid.cells.size(), 0);
    for (std::size_t q = 0; q < result.points.X.size(); ++q) {
      const int c = result.points.cell[q];
      CHECK(holds(grid.corners(c), result.points.X[q]));
      ++count[c];
    }
    int crossed = 0, divided = 0;
    for (std::size_t c = 0; c < count.size(); ++c) {
      double low = 1e9, high = -1e9;
      for (const Vec3& x : grid.corners(c)) {
        low = std::min(low, x[0]);
        high = std::max(high, x[0]);
      }
      const bool crosses = low < kink && kink < high;
      crossed += crosses;
      divided += count[c] > 4;
      REQUIRE((crosses || count[c] == 4));
    }
    CHECK(crossed == 96);            // one layer of 16 cubes
    CHECK(divided > 0.5 * crossed);  // cell and parts may be right, or wrong alike, by accident
    CHECK(result.divided_cells == divided);
    CHECK((result.limited_cells == 0) == (result.worst_error <= 0.003));
  }
}

TEST_CASE("An accuracy out of reach stops at the depth limit and says so", "[quadrature]") {
  const Grid grid(1);
  const Integrand f = [](const Vec3& x) -> Vec3 { return x.array().exp(); };
  for (int division : {2, 4, 8}) {
    for (int depth : {0, 1, 2}) {
      const auto result =
          makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{1e-300, 1, division, depth}, f);
      const int leaves = 6 * static_cast<int>(std::pow(division, depth));
      CHECK(static_cast<int>(result.points.X.size()) == leaves);
      CHECK(result.limited_cells == leaves);
      CHECK(result.deepest == depth);
      CHECK(result.divided_cells == (depth > 0 ? 6 : 0));
      CHECK(result.worst_error > 1e-6);
    }
  }
}

TEST_CASE("A generous accuracy leaves the plain rule, bit for bit", "[quadrature]") {
  const Grid grid(3);
  const Integrand f = [](const Vec3& x) -> Vec3 { return (x.array() * 5).exp(); };
  for (int per_cell : {1, 4, 5}) {
    const auto plain = makeIntegrationPoints(grid.X, grid.cells, grid.volume, per_cell);
    const auto result = makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{1e9, per_cell, 8, 6}, f);
    CHECK(result.points.X == plain.X);
    CHECK(result.points.volume == plain.volume);
    CHECK(result.points.cell == plain.cell);
    CHECK(result.divided_cells == 0);
    CHECK(result.worst_error > 0);
  }
}

TEST_CASE("A component that vanishes asks for nothing - each of the others counts by itself", "[quadrature]") {
  const Grid grid(2);
  const auto flat = [](const Vec3& x) { return Vec3(1e6, 0, (x[0] - 0.5) * 0); };
  CHECK(makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{1e-6, 4, 8, 3}, flat).divided_cells == 0);
  // The second component is far below the first, and still has to be right.
  const auto small = [](const Vec3& x) { return Vec3(1e6, std::exp(8 * x[1]) * 1e-6, 0); };
  const auto result = makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{1e-3, 4, 8, 3}, small);
  CHECK(result.divided_cells > static_cast<int>(grid.cells.size()) / 2);  // by the norm of f none would be
}

TEST_CASE("Adaptive points don't depend on how the cells are shared out", "[quadrature]") {
  const Grid grid(4);
  const Integrand f = [](const Vec3& x) { return Vec3(std::abs(x[0] - 0.37), std::exp(4 * x[1]), 1 / (0.1 + x[2])); };
  const AdaptiveOptions o = AdaptiveOptions{0.01, 4, 4, 5};
  const auto all = makeAdaptivePoints(grid.X, grid.cells, grid.volume, o, f);
  const auto again = makeAdaptivePoints(grid.X, grid.cells, grid.volume, o, f);
  CHECK(all.points.X == again.points.X);
  CHECK(all.points.volume == again.points.volume);
  std::size_t q = 0;
  int limited = 0;
  for (std::size_t c = 0; c < grid.cells.size(); ++c) {
    const auto one = makeAdaptivePoints(grid.X, {grid.cells[c]}, {grid.volume[c]}, o, f);
    limited += one.limited_cells;
    for (std::size_t k = 0; k < one.points.X.size(); ++k, ++q) {
      REQUIRE(all.points.X[q] == one.points.X[k]);
      REQUIRE(all.points.volume[q] == one.points.volume[k]);
      REQUIRE(all.points.cell[q] == static_cast<int>(c));
    }
  }
  CHECK(q == all.points.X.size());
  CHECK(limited == all.limited_cells);
}

TEST_CASE("Where the integrand is not finite, cells stay whole and the places are told", "[quadrature]") {
  const Grid grid(2);
  const Integrand f = [](const Vec3& x) {
    return x[2] > 0.5 ? Vec3::Constant(std::numeric_limits<double>::quiet_NaN()).eval()
                      : Vec3(std::exp(9 * x[0]), 1, 1);
  };
  const auto result = makeAdaptivePoints(grid.X, grid.cells, grid.volume, AdaptiveOptions{1e-3, 4, 8, 2}, f);
  REQUIRE_FALSE(result.not_finite.empty());
  for (const Vec3& x : result.not_finite) CHECK(x[2] > 0.5);
  std::vector<int> count(grid.cells.size(), 0);
  for (int c : result.points.cell) ++count[c];
  for (std::size_t c = 0; c < count.size(); ++c) CHECK((count[c] == 4) == (centroid(grid.corners(c))[2] > 0.5));
  const auto sums = cellSums(result.points, grid.cells.size());
  for (std::size_t c = 0; c < sums.size(); ++c) CHECK(sums[c] == Approx(grid.volume[c]).epsilon(1e-12));
}

TEST_CASE("Impossible options of the adaptive quadrature are refused", "[quadrature][input]") {
  const Grid grid(1);
  const Integrand f = [](const Vec3& x) -> Vec3 { return x.array().exp(); };
  const auto refused = [&](const AdaptiveOptions& o) {
    CHECK_THROWS_AS(makeAdaptivePoints(grid.X, grid.cells, grid.volume, o, f), InputError);
  };
  for (double accuracy : {0.0, -0.1, std::numeric_limits<double>::quiet_NaN()})
    refused(AdaptiveOptions{accuracy, 4, 8, 3});
  for (int per_cell : {0, 2, 3, 6, -1}) refused(AdaptiveOptions{0.1, per_cell, 8, 3});
  for (int division : {0, 1, 3, 5, 16, -2}) refused(AdaptiveOptions{0.1, 4, division, 3});
  refused(AdaptiveOptions{0.1, 4, 8, -1});
  refused(AdaptiveOptions{0.1, 4, 8, 7});
  refused(AdaptiveOptions{0.1, 4, 4, 10});
  refused(AdaptiveOptions{0.1, 4, 2, 19});
  AdaptiveOptions few = AdaptiveOptions{1e-12, 4, 8, 3};
  few.max_points = 1000;
  CHECK_THROWS_WITH(makeAdaptivePoints(grid.X, grid.cells, grid.volume, few, f),
                    Catch::Contains("more than 1000 points"));
}

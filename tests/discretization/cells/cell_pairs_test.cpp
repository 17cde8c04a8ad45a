#include "discretization/cells/cell_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "base/input_error.h"
#include "discretization/bodies.h"

using namespace palpate;

namespace {

/// A dumbbell's nodes and cells, those on either side of its waist of different groups.
struct PairedBody {
  SurfaceTree tree{bodies::dumbbell()};
  NodeCloud cloud;
  BackgroundCells cells;
  std::vector<int> group;

  PairedBody() {
    SpacingField field;
    field.spacing = 0.01;
    cloud = makeNodeCloud(tree, field, 1);
    cells = makeBackgroundCells(cloud, tree);
    for (int c = 0; c < count(); ++c) group.push_back(centroid(c).x() < 0 ? 0 : 1);
  }

  int count() const { return static_cast<int>(cells.cells.size()); }

  Vec3 centroid(int c) const {
    Vec3 sum = Vec3::Zero();
    for (int node : cells.cells[c]) sum += cloud.X[node];
    return sum / 4;
  }

  /// What joining two cells adds to their second moment, over the pair's volume^(5/3).
  double added(int a, int b) const {
    const double V = cells.volume[a], W = cells.volume[b];
    return V * W / (V + W) * (centroid(a) - centroid(b)).squaredNorm() / std::pow(V + W, 5.0 / 3);
  }
};

int pointCountOf(const std::vector<int>& partner) {
  const auto single = std::count(partner.begin(), partner.end(), -1);
  return static_cast<int>(single + (static_cast<std::ptrdiff_t>(partner.size()) - single) / 2);
}

}  // namespace

TEST_CASE("Neighbouring cells share three nodes, and every inner face is between two", "[cell_pairs]") {
  const PairedBody body;
  const auto neighbours = neighbouringCells(body.cells.cells);
  CHECK(4 * body.cells.cells.size() == 2 * neighbours.size() + boundaryFacets(body.cells.cells).size());
  for (const auto& [a, b] : neighbours) {
    REQUIRE(a < b);
    const auto &p = body.cells.cells[a], &q = body.cells.cells[b];
    REQUIRE(std::count_if(p.begin(), p.end(),
                          [&](int node) { return std::find(q.begin(), q.end(), node) != q.end(); }) == 3);
  }
}

TEST_CASE("As many cells are paired as asked, neighbours of one group, the most compact first", "[cell_pairs]") {
  const PairedBody body;
  const auto neighbours = neighbouringCells(body.cells.cells);
  for (const double cells_per_point : {1.0, 1.1, 1.5, 2.0}) {
    const auto partner = pairCells(body.cloud.X, body.cells, body.group, cells_per_point);
    INFO(cells_per_point << " cells per point: " << body.count() << " cells, " << pointCountOf(partner) << " points");
    double largest = 0;
    int pairs = 0;
    for (const auto& [a, b] : neighbours)
      if (partner[a] == b) {
        REQUIRE(partner[b] == a);
        REQUIRE(body.group[a] == body.group[b]);
        largest = std::max(largest, body.added(a, b));
        ++pairs;
      }
    CHECK(pairs == body.count() - pointCountOf(partner));  // none but neighbours
    // Who stayed single had no single neighbour that would have been better than the worst pair.
    for (const auto& [a, b] : neighbours)
      if (partner[a] < 0 && partner[b] < 0 && body.group[a] == body.group[b]) {
        REQUIRE(cells_per_point < 2);
        REQUIRE(body.added(a, b) >= largest * (1 - 1e-12));
      }
    if (cells_per_point < 2)
      CHECK(pointCountOf(partner) == static_cast<int>(std::lround(body.count() / cells_per_point)));
    else
      CHECK(pointCountOf(partner) < 0.6 * body.count());
  }
}

TEST_CASE("Points of pairs integrate linear functions exactly, and each cell has one", "[cell_pairs]") {
  const PairedBody body;
  const auto partner = pairCells(body.cloud.X, body.cells, body.group, 2);
  const IntegrationPoints points = makePairedPoints(body.cloud.X, body.cells, partner);
  REQUIRE(static_cast<int>(points.X.size()) == pointCountOf(partner));
  const auto f = [](const Vec3& x) { return 1 + 3 * x.x() - 20 * x.y() + 7 * x.z(); };
  double exact = 0, sum = 0, volume = 0;
  for (int c = 0; c < body.count(); ++c) exact += body.cells.volume[c] * f(body.centroid(c));
  std::vector<int> seen(body.count(), 0);
  for (std::size_t q = 0; q < points.X.size(); ++q) {
    sum += points.volume[q] * f(points.X[q]);
    volume += points.volume[q];
    ++seen[points.cell[q]];
    if (points.other_cell[q] >= 0) {
      ++seen[points.other_cell[q]];
      CHECK(body.cells.volume[points.cell[q]] >= body.cells.volume[points.other_cell[q]]);
    }
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
  CHECK(volume == Approx(body.cells.total_volume).epsilon(1e-12));
  CHECK(sum == Approx(exact).epsilon(1e-12));
}

TEST_CASE("Fine and coarse parts of a cloud are thinned out alike", "[cell_pairs]") {
  const SurfaceTree tree(boxSurface(Vec3(0.06, 0.06, 0.06), 0.01));
  SpacingField field;
  field.spacing = 0.01;
  field.refinements.push_back({Vec3(0, 0, 0.06), 0.02, 0.004, 0.01, {}});
  const NodeCloud cloud = makeNodeCloud(tree, field, 1);
  const BackgroundCells cells = makeBackgroundCells(cloud, tree);
  const auto partner = pairCells(cloud.X, cells, std::vector<int>(cells.cells.size(), 0), 1.4);
  double median = cells.volume[0];
  {
    std::vector<double> sorted = cells.volume;
    std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
    median = sorted[sorted.size() / 2];
  }
  double paired[2] = {0, 0}, all[2] = {0, 0};
  for (std::size_t c = 0; c < partner.size(); ++c) {
    const int coarse = cells.volume[c] > median ? 1 : 0;
    all[coarse] += 1;
    paired[coarse] += partner[c] >= 0 ? 1 : 0;
  }
  INFO("paired: " << paired[0] / all[0] << " of the fine cells, " << paired[1] / all[1] << " of the coarse");
  CHECK(paired[0] / all[0] > 0.4);
  CHECK(paired[1] / all[1] > 0.4);
}

TEST_CASE("More than two cells or less than one per point are refused", "[cell_pairs]") {
  const PairedBody body;
  for (const double wrong : {0.99, 2.01, std::nan("")})
    CHECK_THROWS_AS(pairCells(body.cloud.X, body.cells, body.group, wrong), InputError);
}

TEST_CASE("Pairs up to the largest moment are those that a number of cells per point gave", "[cell_pairs]") {
  const PairedBody body;
  const auto by_count = pairCells(body.cloud.X, body.cells, body.group, 1.3);
  const double moment = largestPairMoment(body.cloud.X, body.cells, body.group, 1.3);
  CHECK(pairCellsUpTo(body.cloud.X, body.cells, body.group, moment) == by_count);
  const auto fewer = pairCellsUpTo(body.cloud.X, body.cells, body.group, 0.99 * moment);
  CHECK(pointCountOf(fewer) > pointCountOf(by_count));
  CHECK(pointCountOf(pairCellsUpTo(body.cloud.X, body.cells, body.group, 0)) == body.count());
}

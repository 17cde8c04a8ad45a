#include "mechanics/node_patch.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "discretization/cells/cell_pairs.h"
#include "support/test_body.h"

using namespace palpate;

TEST_CASE("Patches of points that stand for two cells have volume and see a uniform dilatation", "[node_patch]") {
  // On a lattice all cells are equal: the middle of a pair lies on the face between, where a corner has no weight.
  for (const double jitter : {0.0, 0.2}) {
    test::TestBody body(4, 0.03, 1, 1.8, 0.1, jitter);
    BackgroundCells cells;
    cells.cells = body.cells;
    updateVolumes(cells, body.X);
    for (std::size_t c = 0; c < cells.cells.size(); ++c)
      if (cells.volume[c] < 0) std::swap(cells.cells[c][2], cells.cells[c][3]);
    updateVolumes(cells, body.X);
    const std::vector<int> one_group(body.cells.size(), 0);
    const IntegrationPoints points = makePairedPoints(body.X, cells, pairCells(body.X, cells, one_group, 2));
    REQUIRE(points.X.size() < 0.7 * body.cells.size());
    const NodePatches patches = makeNodePatches(body.X, cells.cells, points.X, points.volume, points.cell,
                                                std::vector<int>(points.X.size(), 0), body.materials);
    for (std::size_t q = 0; q < points.X.size(); ++q) {
      for (int a = 0; a < 4; ++a) {
        REQUIRE(patches.weight[q][a] > 0);
        REQUIRE(patches.volume[patches.node[q][a]] > 0);
      }
      CHECK(std::accumulate(patches.weight[q].begin(), patches.weight[q].end(), 0.0) == Approx(1).epsilon(1e-14));
    }
    CHECK(std::accumulate(patches.volume.begin(), patches.volume.end(), 0.0) ==
          Approx(cells.total_volume).epsilon(1e-12));
    const double dilatation = 0.01, expected = body.materials[0].bulk_modulus * dilatation;
    for (const double p : patchPressure(patches, points.volume, std::vector<double>(points.X.size(), dilatation)))
      CHECK(p == Approx(expected).epsilon(1e-12));
  }
}

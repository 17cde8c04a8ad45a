#include <catch2/catch.hpp>

#include <numeric>

#include "mechanics/lumped_mass.h"

using namespace palpate;

namespace {
const std::vector<Vec3> X = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
const std::vector<std::array<int, 4>> cells = {{0, 1, 2, 3}, {1, 2, 3, 4}};
double total(const std::vector<double>& mass) { return std::accumulate(mass.begin(), mass.end(), 0.0); }
}  // namespace

TEST_CASE("Each vertex gets a quarter of its cells' masses", "[mass]") {
  const std::vector<double> mass = lumpedMass(X, cells, {1.0 / 6, 1.0 / 3}, {1200, 900});
  CHECK(mass[0] == Approx(50));       // 200 kg / 4
  CHECK(mass[1] == Approx(50 + 75));  // and 300 kg / 4
  CHECK(mass[4] == Approx(75));
  CHECK(total(mass) == Approx(500).epsilon(1e-14));
}

TEST_CASE("Nodes outside all cells share their nearest node's mass and keep the total", "[mass]") {
  std::vector<Vec3> with_orphans = X;
  with_orphans.push_back({1.2, 1.2, 1.2});  // nearest: node 4
  with_orphans.push_back({1.1, 1.0, 1.0});  // nearest: node 4
  with_orphans.push_back({-0.1, 0, 0});     // nearest: node 0
  const std::vector<double> mass = lumpedMass(with_orphans, cells, {1.0 / 6, 1.0 / 3}, {1200, 900});
  CHECK(mass[4] == Approx(25));
  CHECK(mass[5] == Approx(25));
  CHECK(mass[6] == Approx(25));
  CHECK(mass[0] == Approx(25));
  CHECK(mass[7] == Approx(25));
  CHECK(total(mass) == Approx(500).epsilon(1e-14));
}

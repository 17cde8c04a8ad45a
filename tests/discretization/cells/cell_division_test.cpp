#include "discretization/cells/cell_division.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "discretization/tetrahedra.h"

using namespace palpate;

TEST_CASE("A divided cell is tiled by parts of equal volume", "[quadrature]") {
  std::mt19937 random(3);
  std::exponential_distribution<double> exponential(1);
  for (int division : {2, 4, 8})
    for (int depth = 0; depth < 5; ++depth) {
      std::array<Corners, 8> parts;
      divideCell(general, division, depth, parts);
      INFO("division " << division << ", depth " << depth);
      for (int i = 0; i < division; ++i)
        CHECK(volumeOf(parts[i]) == Approx(volumeOf(general) / division).epsilon(1e-14));
      for (int trial = 0; trial < 300; ++trial) {  // evenly spread over the simplex
        double l[4], sum = 0;
        for (double& a : l) sum += a = exponential(random);
        Vec3 x = Vec3::Zero();
        for (int k = 0; k < 4; ++k) x += l[k] / sum * general[k];
        int owners = 0;
        for (int i = 0; i < division; ++i) owners += holds(parts[i], x);
        REQUIRE(owners == 1);
      }
    }
}

TEST_CASE("Division in 2 halves the longest edge, in 8 uses the octahedron's shortest diagonal", "[quadrature]") {
  const auto longest = [](const Corners& c) {
    double length = 0;
    for (const Vec3& a : c)
      for (const Vec3& b : c) length = std::max(length, (a - b).norm());
    return length;
  };
  std::array<Corners, 8> parts;
  divideCell(general, 2, 0, parts);
  for (int i = 0; i < 2; ++i) CHECK(longest(parts[i]) < longest(general));
  // A flat diamond: the diagonals of its octahedron are 0.5, 0.5 and 0.05 long.
  const Corners flat = {Vec3(0.5, 0, 0), Vec3(-0.5, 0, 0), Vec3(0, 0.5, 0.05), Vec3(0, -0.5, 0.05)};
  divideCell(flat, 8, 0, parts);
  for (int i = 4; i < 8; ++i) CHECK((parts[i][0] - parts[i][1]).norm() == Approx(0.05));
}

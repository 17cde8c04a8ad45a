#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "discretization/nodes/node_order.h"

using namespace palpate;

namespace {

std::vector<Vec3> randomPoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return random() / 4294967296.0; };
  std::vector<Vec3> X(count);
  for (Vec3& x : X) x = {uniform(), uniform(), uniform()};
  return X;
}

bool isPermutation(std::vector<int> order, std::size_t count) {
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] != static_cast<int>(k)) return false;
  }
  return order.size() == count;
}

/// Mean diagonal of the bounding boxes of consecutive groups.
double meanExtent(const std::vector<Vec3>& X, const std::vector<int>& order, std::size_t group) {
  double sum = 0;
  int count = 0;
  for (std::size_t begin = 0; begin + group <= order.size(); begin += group, ++count) {
    Eigen::AlignedBox3d box;
    for (std::size_t k = begin; k < begin + group; ++k) box.extend(X[order[k]]);
    sum += box.diagonal().norm();
  }
  return sum / count;
}

}  // namespace

TEST_CASE("Bisection order is a permutation for every count", "[order]") {
  for (int count = 0; count < 140; ++count) {
    const std::vector<Vec3> X = randomPoints(count, 7);
    REQUIRE(isPermutation(bisectionOrder(X, 4), X.size()));
  }
}

TEST_CASE("Bisection order makes compact groups of 4 and of 16", "[order]") {
  for (int count : {4096, 4099, 10007}) {  // also counts that no group size divides
    const std::vector<Vec3> X = randomPoints(count, 5);
    const std::vector<int> order = bisectionOrder(X, 4);
    // Edge of the cube that holds 4 and 16 points on average, whose diagonal is 1.73 edges; a cell
    // of bisection is at worst 1 : 1 : 2 (diagonal 1.94 edges), and its points' box a little smaller.
    const double edge4 = std::cbrt(4.0 / count), edge16 = std::cbrt(16.0 / count);
    CHECK(meanExtent(X, order, 4) < 1.35 * edge4);
    CHECK(meanExtent(X, order, 16) < 1.75 * edge16);
  }
}

TEST_CASE("Bisection separates clusters of 16 exactly", "[order]") {
  // 8 tight clusters at a cube's corners: each aligned block of 16 must be one cluster.
  std::vector<Vec3> X = randomPoints(128, 9);
  for (int i = 0; i < 128; ++i) X[i] = 1e-3 * X[i] + Vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const std::vector<int> order = bisectionOrder(X, 4);
  for (int block = 0; block < 8; ++block) {
    std::set<int> clusters;
    for (int k = 0; k < 16; ++k) clusters.insert(order[16 * block + k] % 8);
    CHECK(clusters.size() == 1);
  }
}

TEST_CASE("A sliced order goes through the longest side once, and keeps its groups compact", "[order]") {
  std::vector<Vec3> X = randomPoints(4000, 8);
  for (Vec3& x : X) x.y() *= 5;
  const double distance = std::cbrt(5.0 / 4000);
  const std::vector<int> order = slicedOrder(X, 4, 2);
  REQUIRE(isPermutation(order, X.size()));
  double so_far = 0, back = 0;  // how far a point lies behind the foremost before it
  for (int q : order) {
    so_far = std::max(so_far, X[q].y());
    back = std::max(back, so_far - X[q].y());
  }
  CHECK(back < 1.2 * 2 * 2 * distance);
  CHECK(meanExtent(X, order, 4) < 1.15 * meanExtent(X, bisectionOrder(X, 4), 4));
  // Where the points lie denser, slices are thinner, so that their groups stay as compact as anywhere.
  for (Vec3& x : X) x.y() = x.y() * x.y() / 5;
  CHECK(meanExtent(X, slicedOrder(X, 4, 2), 4) < 1.15 * meanExtent(X, bisectionOrder(X, 4), 4));
  CHECK(slicedOrder(X, 4, 1e3) == bisectionOrder(X, 4));
  CHECK(isPermutation(slicedOrder(randomPoints(7, 1), 4, 0.1), 7));
  CHECK(slicedOrder({}, 4, 2).empty());
  CHECK(slicedOrder({Vec3(1, 2, 3)}, 4, 2) == std::vector<int>{0});
  CHECK(isPermutation(slicedOrder(std::vector<Vec3>(40, Vec3(1, 2, 3)), 4, 2), 40));  // all at one place
}

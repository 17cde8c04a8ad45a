#include "mechanics/point_block_order.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "discretization/nodes/node_order.h"

using namespace palpate;

namespace {

/// Points at random in a cube of n^3 nodes, each supported by the nodes within 1.8 spacings.
struct Cloud {
  std::vector<Vec3> X;
  ShapeTable shape;
  Cloud(int n, int points) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(0, n - 1);
    for (int q = 0; q < points; ++q) {
      const double x = place(random), y = place(random), z = place(random);
      X.emplace_back(x, y, z);
    }
    shape.begin = {0};
    for (const Vec3& x : X) {
      for (int i = 0; i < n * n * n; ++i)
        if ((Vec3(i % n, i / n % n, i / n / n) - x).norm() <= 1.8) shape.node.push_back(i);
      shape.begin.push_back(static_cast<int>(shape.node.size()));
    }
  }

  /// Groups of four nodes in all blocks' unions.
  int groupCount(const std::vector<int>& order) const {
    int groups = 0;
    for (std::size_t first = 0; first < order.size(); first += 4) {
      std::set<int> nodes;
      for (std::size_t k = first; k < first + 4; ++k)
        if (order[k] >= 0)
          nodes.insert(shape.node.begin() + shape.begin[order[k]], shape.node.begin() + shape.begin[order[k] + 1]);
      groups += (static_cast<int>(nodes.size()) + 3) / 4;
    }
    return groups;
  }
};

}  // namespace

TEST_CASE("Blocks exchange points until they share more nodes", "[block-order]") {
  const Cloud cloud(9, 2990);
  std::vector<int> order = bisectionOrder(cloud.X, 4);
  order.resize(3008, -1);
  std::vector<int> better = pointBlockOrder(cloud.shape, order);
  CHECK(cloud.groupCount(better) < 0.97 * cloud.groupCount(order));
  CHECK(pointBlockOrder(cloud.shape, order) == better);
  CHECK(cloud.groupCount(pointBlockOrder(cloud.shape, better)) <= cloud.groupCount(better));
  std::sort(order.begin(), order.end());
  std::sort(better.begin(), better.end());
  CHECK(better == order);
}

TEST_CASE("Blocks that share all nodes, or none to gain, stay as they are", "[block-order]") {
  ShapeTable shape;
  shape.begin = {0};
  std::vector<int> order;
  for (int q = 0; q < 64; ++q) {
    for (int k = 0; k < 4; ++k) shape.node.push_back(q / 4 * 4 + k);
    shape.begin.push_back(static_cast<int>(shape.node.size()));
    order.push_back(q);
  }
  CHECK(pointBlockOrder(shape, order) == order);
  CHECK(pointBlockOrder({}, {}).empty());
}

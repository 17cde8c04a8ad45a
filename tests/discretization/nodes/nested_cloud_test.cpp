#include "discretization/nodes/nested_cloud.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "discretization/bodies.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cloud_statistics.h"
#include "discretization/surface/solids.h"
#include "support/cubes.h"

using namespace palpate;

namespace {

SpacingField ballIn(double coarse, double fine, const Vec3& centre, double radius) {
  SpacingField field = uniform(coarse);
  field.refinements.push_back({centre, radius, fine, 0, {}});
  return field;
}

NestedCloud nestedIn(const TriangleSurface& surface, double h) {
  const SurfaceTree tree(surface);
  const NodeCloud cloud = makeNodeCloud(tree, uniform(h), 1);
  return nestedOrder(cloud, nodeDimensions(cloud, findFeatureEdges(surface), uniform(h)), uniform(h));
}

NodeCloud partOf(const NestedCloud& cloud, const std::vector<int>& live) {
  NodeCloud part;
  for (const int i : live) {
    part.X.push_back(cloud.X[i]);
    part.on_surface.push_back(cloud.on_surface[i]);
  }
  return part;
}

/// Mean length of the cells' edges over the wanted spacing, where the wanted spacing is `h`.
double meanEdge(const NodeCloud& cloud, const SurfaceTree& tree, const SpacingField& wanted, double h) {
  double sum = 0;
  int count = 0;
  for (const auto& cell : makeBackgroundCells(cloud, tree).cells)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) {
        const Vec3 &x = cloud.X[cell[a]], &y = cloud.X[cell[b]];
        if (wanted.at(x) != h || wanted.at(y) != h) continue;
        sum += (x - y).norm() / h;
        ++count;
      }
  return sum / count;
}

}  // namespace

TEST_CASE("What is live far from the tool does not depend on where the tool is", "[nested][whole]") {
  const NestedCloud cloud = nestedIn(boxSurface(Vec3(0.12, 0.08, 0.05), 0.01), 0.005);
  const SpacingField left = ballIn(0.011, 0.005, Vec3(-0.06, 0, 0.05), 0.015),
                     right = ballIn(0.011, 0.005, Vec3(0.06, 0, 0.05), 0.015);
  const auto a = liveNodes(cloud, left), b = liveNodes(cloud, right), coarse = liveNodes(cloud, uniform(0.011));
  REQUIRE(std::is_sorted(a.begin(), a.end()));
  CHECK(std::includes(a.begin(), a.end(), coarse.begin(), coarse.end()));
  CHECK(std::includes(b.begin(), b.end(), coarse.begin(), coarse.end()));
  CHECK(a.size() > coarse.size() + 50);
  CHECK(a.size() < 0.6 * cloud.nodeCount());
  int shared = 0;
  for (int i = 0; i < cloud.nodeCount(); ++i) {
    if (left.at(cloud.X[i]) != 0.011 || right.at(cloud.X[i]) != 0.011) continue;
    const bool in_a = std::binary_search(a.begin(), a.end(), i), in_b = std::binary_search(b.begin(), b.end(), i);
    REQUIRE(in_a == in_b);
    shared += in_a;
  }
  CHECK(shared > 20);
  // Where the finest spacing is wanted every node is live.
  CHECK(static_cast<int>(liveNodes(cloud, uniform(0.005)).size()) == cloud.nodeCount());
  CHECK(nestedIn(boxSurface(Vec3(0.12, 0.08, 0.05), 0.01), 0.005).coarsest == cloud.coarsest);
}

TEST_CASE("Live clouds keep the wanted spacing, the surface, corners and edges", "[nested][whole]") {
  struct Case {
    const char* name;
    TriangleSurface surface;
    Vec3 tool;
  };
  const std::vector<Case> cases = {{"box", boxSurface(Vec3(0.12, 0.08, 0.05), 0.01), Vec3(-0.03, 0, 0.05)},
                                   {"ellipsoid", ellipsoidSurface(Vec3(0.06, 0.045, 0.03), 0.005), Vec3(0, 0, 0.03)}};
  for (const Case& c : cases) {
    DYNAMIC_SECTION(c.name) {
      const SurfaceTree tree(c.surface);
      const NestedCloud nested = nestedIn(c.surface, 0.005);
      for (const double coarse : {0.0075, 0.01, 0.0125}) {
        CAPTURE(coarse);
        const SpacingField wanted = ballIn(coarse, 0.005, c.tool, 0.02);
        const NodeCloud cloud = partOf(nested, liveNodes(nested, wanted));
        const CloudStatistics statistics = cloudStatistics(cloud, tree, wanted);
        CHECK(statistics.closest > 0.5);
        CHECK(statistics.depth > 0.4);
        CHECK(meanEdge(cloud, tree, wanted, 0.005) == Approx(1).epsilon(0.12));
        CHECK(meanEdge(cloud, tree, wanted, coarse) == Approx(1).epsilon(0.12));
        for (std::size_t i = 0; i < cloud.X.size(); ++i)
          REQUIRE((tree.closest(cloud.X[i]).distance < 1e-12) == (cloud.on_surface[i] != 0));
      }
    }
  }
  const NestedCloud box = nestedIn(cases[0].surface, 0.005);
  const auto live = liveNodes(box, uniform(0.015));
  int corners = 0;
  std::vector<double> along;  // of one edge
  for (const int i : live) {
    const Vec3 x = box.X[i].cwiseAbs();
    corners += std::abs(x.x() - 0.06) < 1e-9 && std::abs(x.y() - 0.04) < 1e-9 &&
               std::min(x.z(), std::abs(x.z() - 0.05)) < 1e-9;
    if (box.X[i].y() > 0.04 - 1e-9 && x.z() > 0.05 - 1e-9) along.push_back(box.X[i].x());
  }
  CHECK(corners == 8);
  std::sort(along.begin(), along.end());
  REQUIRE(along.size() > 5);
  // A node that is not live has a live one within 0.7 spacings; the middle of a gap is half a fine spacing from a node.
  for (std::size_t k = 1; k < along.size(); ++k) CHECK(along[k] - along[k - 1] < 2 * 0.7 * 0.015 + 0.005);
}

TEST_CASE("Nodes that are to be kept are live in every cloud", "[nested]") {
  NestedCloud cloud = nestedIn(boxSurface(Vec3(0.06, 0.06, 0.03), 0.01), 0.006);
  std::vector<int> members;  // a patch smaller than the coarse spacing
  for (int i = 0; i < cloud.nodeCount(); ++i)
    if (cloud.on_surface[i] && (cloud.X[i] - Vec3(0.012, 0.007, 0.03)).norm() < 0.009) members.push_back(i);
  REQUIRE(members.size() > 4);
  keepLive(members, 3, cloud);
  const auto live = liveNodes(cloud, uniform(10));
  CHECK(std::count_if(members.begin(), members.end(),
                      [&](int i) { return std::binary_search(live.begin(), live.end(), i); }) == 3);
}

TEST_CASE("Of a pair of nodes across narrow air both are live or neither", "[nested]") {
  constexpr double mm = 1e-3, h = 1.5 * mm, coarse = 4.5 * mm, air = 1.2 * mm;
  const TriangleSurface surface =
      test::cubes({21, 12, 20}, mm, [](const Vec3& x) { return std::abs(x.x() - 10.5) > 0.5 || x.z() < 8; });
  const SurfaceTree tree(surface);
  const NodeCloud cloud = makeNodeCloud(tree, uniform(h), 1, {}, {}, air);
  const std::vector<int> pairs = pairsAcrossAir(cloud, tree, air);
  const NestedCloud nested =
      nestedOrder(cloud, nodeDimensions(cloud, findFeatureEdges(surface), uniform(h)), uniform(h), pairs);
  const auto live = liveNodes(nested, uniform(coarse));
  int paired = 0;
  for (const int i : live) {
    if (pairs[i] < 0) continue;
    ++paired;
    CHECK((cloud.X[pairs[i]] - cloud.X[i]).norm() == Approx(mm));
    CHECK(std::binary_search(live.begin(), live.end(), pairs[i]));
  }
  CHECK(paired > 0.8 * 2 * 144e-6 / (0.866 * coarse * coarse));
  CHECK(std::abs(makeBackgroundCells(partOf(nested, live), tree).volumeError()) < 0.01);
}

#include <catch2/catch.hpp>

#include <Eigen/LU>

#include <random>

#include "base/input_error.h"
#include "discretization/bodies.h"
#include "discretization/cells/background_cells.h"
#include "discretization/cells/delaunay.h"
#include "discretization/surface/surface_geometry.h"
#include "support/cubes.h"

using namespace palpate;

namespace {

NodeCloud cloudOf(const SurfaceTree& tree, double h) {
  SpacingField field;
  field.spacing = h;
  return makeNodeCloud(tree, field, 1);
}

std::vector<Vec3> randomPoints(int count) {
  std::mt19937 random(11);
  std::vector<Vec3> X(count);
  for (Vec3& x : X) {
    for (double& component : x) component = random() / 4294967296.0;
  }
  return X;
}

double totalVolume(const std::vector<Vec3>& X, const std::vector<std::array<int, 4>>& cells) {
  double sum = 0;
  for (const auto& [a, b, c, d] : cells) {
    const double volume = tetrahedronVolume(X[a], X[b], X[c], X[d]);
    REQUIRE(volume > 0);
    sum += volume;
  }
  return sum;
}

std::vector<int> unusedNodes(const BackgroundCells& cells, const NodeCloud& cloud) {
  std::vector<int> unused;
  for (int i = 0; i < static_cast<int>(cloud.X.size()); ++i)
    if (std::none_of(cells.cells.begin(), cells.cells.end(),
                     [i](const auto& cell) { return std::count(cell.begin(), cell.end(), i) > 0; }))
      unused.push_back(i);
  return unused;
}

}  // namespace

TEST_CASE("No point lies inside the circumsphere of a Delaunay cell", "[delaunay]") {
  const std::vector<Vec3> X = randomPoints(400);
  const std::vector<std::array<int, 4>> cells = delaunay(X);
  REQUIRE(cells.size() > 2000);
  for (const auto& [a, b, c, d] : cells) {
    Mat3 edges;
    edges << (X[b] - X[a]).transpose(), (X[c] - X[a]).transpose(), (X[d] - X[a]).transpose();
    const Vec3 to_centre = edges.inverse() * edges.rowwise().squaredNorm() / 2;
    const Vec3 centre = X[a] + to_centre;
    double nearest = 1e300;
    for (const Vec3& x : X) nearest = std::min(nearest, (x - centre).norm());
    // Flat cells have far centres; rounding grows with the radius.
    REQUIRE(nearest > to_centre.norm() * (1 - 1e-9));
  }
}

TEST_CASE("Delaunay cells of a cospherical lattice fill the cube", "[delaunay]") {
  std::vector<Vec3> X;
  for (int i = 0; i < 216; ++i) X.push_back(0.01 * Vec3(i % 6, (i / 6) % 6, i / 36));
  CHECK(totalVolume(X, delaunay(X)) == Approx(std::pow(0.05, 3)).epsilon(1e-10));
}

TEST_CASE("Points in a plane, and too few points, are refused", "[delaunay][input]") {
  std::vector<Vec3> flat = randomPoints(30);
  for (Vec3& x : flat) x.z() = 0.5;
  CHECK_THROWS_AS(delaunay(flat), std::runtime_error);
  CHECK_THROWS_AS(delaunay({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()}), std::runtime_error);

  NodeCloud cloud;
  cloud.X = flat;
  cloud.on_surface.assign(flat.size(), 1);
  CHECK_THROWS_AS(makeBackgroundCells(cloud, SurfaceTree(boxSurface(Vec3::Ones(), 1))), InputError);
  // What qhull says of it, but not its page of advice.
  CHECK_THROWS_WITH(delaunay(flat), Catch::Contains("flat") && !Catch::Contains("\n"));
}

TEST_CASE("The cells of a box hold its volume exactly and use all nodes", "[cells]") {
  const Vec3 size(0.1, 0.08, 0.05);
  for (double h : {0.02, 0.01, 0.007}) {
    const SurfaceTree tree(boxSurface(size, 0.02));
    const NodeCloud cloud = cloudOf(tree, h);
    const BackgroundCells cells = makeBackgroundCells(cloud, tree);
    CHECK(cells.surface_volume == Approx(4e-4).epsilon(1e-13));
    CHECK(std::abs(cells.volumeError()) < 1e-11);
    CHECK(totalVolume(cloud.X, cells.cells) == Approx(cells.total_volume).epsilon(1e-14));
    CHECK(unusedNodes(cells, cloud).empty());
  }
}

TEST_CASE("Concave bodies are not bridged", "[cells]") {
  const SurfaceTree bracket(bodies::angleBracket());
  const NodeCloud corner = cloudOf(bracket, 0.01);
  const BackgroundCells cells = makeBackgroundCells(corner, bracket);
  CHECK(cells.surface_volume == Approx((0.01 - 0.0036) * 0.05));
  CHECK(std::abs(cells.volumeError()) < 5e-3);  // its convex hull is 28 % larger
  CHECK(delaunay(corner.X).size() > cells.cells.size() + 100);

  const SurfaceTree dumbbell(bodies::dumbbell());
  const NodeCloud cloud = cloudOf(dumbbell, 0.006);
  const BackgroundCells lobes = makeBackgroundCells(cloud, dumbbell);
  CHECK(std::abs(lobes.volumeError()) < 0.03);
  CHECK(unusedNodes(lobes, cloud).empty());
  for (const std::array<int, 4>& cell : lobes.cells) {
    Vec3 centroid = Vec3::Zero();
    for (int i : cell) centroid += cloud.X[i] / 4;
    REQUIRE(dumbbell.signedDistance(centroid) < 1e-4);
  }
}

TEST_CASE("Both sides of a narrow slit have their own nodes, and cells end at it", "[cells]") {
  constexpr double mm = 1e-3;
  const SurfaceTree tree(
      test::cubes({21, 12, 20}, mm, [](const Vec3& x) { return std::abs(x.x() - 10.5) > 0.5 || x.z() < 8; }));
  for (const double h : {0.0017, 0.003, 0.005}) {  // of which the slit is 0.6 .. 0.2
    const NodeCloud cloud = cloudOf(tree, h);
    const auto inSlit = [&](int i, double wall) {
      return std::abs(cloud.X[i].x() - wall) < 1e-9 && cloud.X[i].z() > 8 * mm;
    };
    int left = 0, right = 0;
    for (int i = 0; i < static_cast<int>(cloud.X.size()); ++i) {
      left += inSlit(i, 10 * mm);
      right += inSlit(i, 11 * mm);
    }
    CHECK(std::min(left, right) > 0.9 * 144e-6 / (0.866 * h * h));
    CHECK(std::max(left, right) < 1.1 * std::min(left, right));
    const BackgroundCells cells = makeBackgroundCells(cloud, tree);
    CHECK(std::abs(cells.volumeError()) < 0.01);
    CHECK(unusedNodes(cells, cloud).empty());
    int across = 0;
    for (const auto& cell : cells.cells) {
      const auto isBeside = [&](double side) {
        return std::any_of(cell.begin(), cell.end(), [&](int i) {
          return side * (cloud.X[i].x() - 10.5 * mm) > 0.4 * mm && cloud.X[i].z() > 8 * mm + 1e-9;
        });
      };
      across += isBeside(-1) && isBeside(1);
    }
    CHECK(across == 0);
  }
}

TEST_CASE("The boundary of the cells is closed and encloses their volume", "[cells]") {
  const SurfaceTree tree(bodies::liverLike());
  const NodeCloud cloud = cloudOf(tree, 0.012);
  const BackgroundCells cells = makeBackgroundCells(cloud, tree);
  TriangleSurface boundary;
  boundary.vertices = cloud.X;
  boundary.triangles = boundaryFacets(cells.cells);
  Vec3 sum = Vec3::Zero();
  for (int t = 0; t < static_cast<int>(boundary.triangles.size()); ++t) sum += areaVector(boundary, t);
  CHECK(sum.norm() < 1e-14);  // m^2, of 0.04
  CHECK(signedVolume(boundary) == Approx(cells.total_volume).epsilon(1e-12));
}

TEST_CASE("No cell uses a node outside", "[cells]") {
  const SurfaceTree tree(boxSurface({0.1, 0.1, 0.1}, 0.05));
  NodeCloud cloud = cloudOf(tree, 0.02);
  cloud.X.push_back({0.3, 0, 0.05});  // outside: all its cells are dropped
  cloud.on_surface.push_back(1);
  const BackgroundCells cells = makeBackgroundCells(cloud, tree);
  CHECK(unusedNodes(cells, cloud) == std::vector<int>{static_cast<int>(cloud.X.size()) - 1});
}

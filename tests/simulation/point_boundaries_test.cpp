#include "setup/point_boundaries.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "discretization/surface/solids.h"
#include "setup/body_points.h"
#include "support/small_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using Catch::Matchers::Contains;

namespace {

/// The block, points of whose top go down.
Scene sceneWith(const PointLoad& load) {
  Scene scene = test::blockScene();
  BoundarySpec points;
  points.name = "electrode";
  points.points = std::make_shared<PointLoad>(load);
  points.duration = 1;
  scene.boundaries.push_back(points);
  return scene;
}

SurfaceTree blockTree() { return SurfaceTree(boxSurface(Vec3(0.06, 0.06, 0.03), 0.004)); }

}  // namespace

TEST_CASE("Measured points are imposed exactly where they are on the surface", "[simulation][points]") {
  PointLoad load;
  load.before = {{0.003, 0.001, 0.031}, {-0.0171, 0.004, 0.03}, {0.004, -0.0193, 0.0297}};
  load.after = load.before;
  load.after[0] += Vec3(0.001, 0, -0.004);
  load.after[1] += Vec3(0, 0, -0.002);
  load.after[2] += Vec3(0, 0.0005, -0.001);
  const Scene scene = withPointBoundaries(sceneWith(load), blockTree());
  REQUIRE(scene.boundaries.size() == 4);
  CHECK(scene.boundaries[1].name == "electrode 1");
  CHECK(scene.boundaries[1].region.point.z() == Approx(0.03));  // the nearest point of the surface
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 1, 1e-3);
  REQUIRE(solver.advanceTo(1).converged);

  std::vector<Vec3> at;
  for (std::size_t b = 1; b < 4; ++b) at.push_back(scene.boundaries[b].region.point);
  const ShapeTable shape = shapeAt(model, at);
  const std::vector<Vec3> u = fieldAt(shape, solver.body().u);
  for (std::size_t k = 0; k < 3; ++k) CHECK((u[k] - (load.after[k] - load.before[k])).norm() < 1e-12);
  // Each is a boundary of its own: it says what holds it, and all together with the base carry nothing.
  Vec3 sum = Vec3::Zero();
  std::vector<Vec3> at_nodes(model.X.size(), Vec3::Zero());
  for (const Reaction& r : solver.body().reactions()) sum += r.force;
  solver.body().addNodeReactions(at_nodes);
  Vec3 spread = Vec3::Zero();
  for (const Vec3& f : at_nodes) spread += f;
  const double pressed = solver.body().reactions()[1].force.norm();
  CHECK(pressed > 1e-3);
  CHECK(sum.norm() < 0.02 * pressed);  // the solution's tolerance
  CHECK((spread - sum).norm() < 1e-9 * pressed);
}

TEST_CASE("Points measured once start from the nearest place of the surface", "[simulation][points]") {
  PointLoad load;
  load.after = {{0.01, 0.01, 0.026}};
  const Scene scene = withPointBoundaries(sceneWith(load), blockTree());
  CHECK((scene.boundaries[1].region.point - Vec3(0.01, 0.01, 0.03)).norm() < 1e-12);
  CHECK((scene.boundaries[1].translation - Vec3(0, 0, -0.004)).norm() < 1e-12);
}

TEST_CASE("Points nearer than half the spacing are joined, and those far away refused", "[simulation][points]") {
  PointLoad load;
  load.file = "e.csv";
  load.line = {2, 3, 4};
  load.before = {{0, 0, 0.03}, {0.004, 0, 0.03}, {0.02, 0, 0.03}};
  load.after = {{0, 0, 0.028}, {0.004, 0, 0.026}, {0.02, 0, 0.03}};
  std::string said;
  const Scene scene = withPointBoundaries(sceneWith(load), blockTree(), [&](const std::string& text) { said = text; });
  REQUIRE(scene.boundaries.size() == 3);
  CHECK((scene.boundaries[1].region.point - Vec3(0.002, 0, 0.03)).norm() < 1e-12);
  CHECK((scene.boundaries[1].translation - Vec3(0, 0, -0.003)).norm() < 1e-12);
  CHECK_THAT(said, Contains("of 3 points 2 are left"));

  load.before[1].z() = 0.08;
  CHECK_THAT(refusal([&] { withPointBoundaries(sceneWith(load), blockTree()); }),
             Contains("e.csv:3") && Contains("50 mm") && Contains("frame"));
}

TEST_CASE("A point in a region that is held is refused", "[simulation][points]") {
  PointLoad load;
  load.file = "e.csv";
  load.line = {2, 3, 4};
  load.after = {{0, 0, 0.031}, {0, 0, -0.001}, {0.02, 0, -0.001}};
  Scene scene = sceneWith(load);
  scene.boundaries[0].place = {"s.toml", 7};
  // Before there are nodes, and which.
  CHECK_THAT(refusal([&] { withPointBoundaries(scene, blockTree()); }),
             Contains("e.csv:3: ") && Contains("is held at s.toml:7") && Contains("lines 4"));
  // Beside the region, by what its nodes hold.
  load.after = {{0.0301, 0.006, 0.001}};
  load.line = {5};
  scene = sceneWith(load);
  CHECK_THAT(refusal([&] { test::blockModel(withPointBoundaries(scene, blockTree())); }),
             Contains("e.csv:5: ") && Contains("\"electrode 1\"") && Contains("nearer than half the spacing"));
}

TEST_CASE("A body that only prescribed regions hold is accepted where they leave it no motion as a whole",
          "[simulation][points]") {
  Scene scene = test::blockScene();
  scene.boundaries[0].duration = 1;  // the base is moved: three shifts and three turns are
  scene.boundaries[0].translation = Vec3(0, 0, 1e-3);
  CHECK(test::blockModel(scene).nodeCount() > 10);
  scene.boundaries[0].component[0] = false;
  CHECK_THAT(refusal([&] { test::blockModel(scene); }), Contains("leaves the organ 1 of its six motions"));
  scene.boundaries[0].component[1] = false;  // only heights: both slides, and the turn about z
  CHECK_THAT(refusal([&] { test::blockModel(scene); }), Contains("leaves the organ 3 of its six motions"));
  PointLoad load;
  load.after = {{0.01, 0.01, 0.031}, {-0.01, -0.01, 0.031}};
  scene = sceneWith(load);
  scene.boundaries.erase(scene.boundaries.begin());
  CHECK_THAT(refusal([&] { test::blockModel(withPointBoundaries(scene, blockTree())); }), Contains("1 of its six"));
}

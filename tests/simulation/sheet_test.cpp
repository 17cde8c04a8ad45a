#include "setup/sheet.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "batch/static_solver.h"
#include "discretization/surface/solids.h"
#include "setup/point_boundaries.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

SurfaceTree slabTree() { return SurfaceTree(boxSurface(Vec3(0.06, 0.06, 0.03), 0.004)); }

/// A grid of 3 x 4 points on the block's top.
MovedPoints measuredGrid(const std::function<Vec3(const Vec3&)>& motion) {
  MovedPoints points;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 4; ++j) {
      points.X.emplace_back(-0.011 + 0.011 * i, -0.015 + 0.01 * j, 0.03);
      points.u.push_back(motion(points.X.back()));
    }
  return points;
}

}  // namespace

TEST_CASE("A sheet that is only tilted and stretched stays so between the points", "[simulation][sheet]") {
  const auto motion = [](const Vec3& X) {
    return Vec3(1e-3 + 0.1 * X.x(), 0.05 * X.y(), -0.004 + 0.2 * X.x() - 0.1 * X.y());
  };
  const MovedPoints sheet = sheetBetween(measuredGrid(motion), slabTree(), 0.006);
  REQUIRE(sheet.X.size() > 8);
  for (std::size_t k = 0; k < sheet.X.size(); ++k) {
    CHECK(sheet.X[k].z() == Approx(0.03));  // none on the sides or below
    CHECK(std::abs(sheet.X[k].x()) < 0.011 + 0.0051);
    CHECK(std::abs(sheet.X[k].y()) < 0.015 + 0.0051);
    CHECK((sheet.u[k] - motion(sheet.X[k])).norm() < 1e-12);  // linear fields are reproduced
  }
  for (std::size_t a = 0; a < sheet.X.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) CHECK((sheet.X[a] - sheet.X[b]).norm() >= 0.006);
}

TEST_CASE("A dent is smooth between the points that measured it", "[simulation][sheet]") {
  const auto dent = [](const Vec3& X) { return Vec3(0, 0, -0.005 * std::exp(-X.squaredNorm() / 8e-4 + 9e-4 / 8e-4)); };
  const MovedPoints measured = measuredGrid(dent), sheet = sheetBetween(measured, slabTree(), 0.004);
  const double deepest = 0.005;
  double worst = 0;
  for (std::size_t k = 0; k < sheet.X.size(); ++k) worst = std::max(worst, (sheet.u[k] - dent(sheet.X[k])).norm());
  CHECK(worst < 0.08 * deepest);  // 0.053, beyond the outermost points
  CHECK(sheetBetween({{measured.X[0], measured.X[1]}, {measured.u[0], measured.u[1]}}, slabTree(), 0.004).X.empty());
}

TEST_CASE("The skin goes with the sheet, and the points stay exact", "[simulation][sheet]") {
  PointLoad load;
  const MovedPoints measured = measuredGrid([](const Vec3&) { return Vec3(0, 0, -0.003); });
  load.before = measured.X;
  for (const Vec3& X : load.before) load.after.push_back(X - Vec3(0, 0, 0.003));
  load.sheet = true;
  Scene scene = test::blockScene(0.009);
  BoundarySpec points;
  points.name = "electrode";
  points.points = std::make_shared<PointLoad>(load);
  points.duration = 1;
  scene.boundaries.push_back(points);
  const Scene with_points = withPointBoundaries(scene, slabTree());
  REQUIRE(with_points.boundaries.size() > 1 + load.after.size());
  CHECK(with_points.boundaries.back().name.starts_with("electrode sheet"));
  const Model model = test::blockModel(with_points);
  StaticSolver solver(model, 1, 1e-3);
  REQUIRE(solver.advanceTo(1).converged);
  const std::vector<Vec3> u = fieldAt(model.skin, solver.body().u);
  double sum = 0;
  int count = 0;
  for (int v = 0; v < model.skin.vertexCount(); ++v) {
    const Vec3& X = model.skin.surface.vertices[v];
    if (X.z() < 0.03 - 1e-9 || std::abs(X.x()) > 0.011 || std::abs(X.y()) > 0.015) continue;
    sum += (u[v] - Vec3(0, 0, -0.003)).squaredNorm();
    ++count;
  }
  REQUIRE(count > 20);
  CHECK(std::sqrt(sum / count) < 0.1 * 0.003);  // the nodes are no nearer to each other than the sheet's points
  const std::vector<Reaction>& reactions = solver.body().reactions();
  CHECK(reactions.size() == with_points.boundaries.size());
}

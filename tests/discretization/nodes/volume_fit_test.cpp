#include <catch2/catch.hpp>

#include "discretization/bodies.h"
#include "discretization/nodes/volume_fit.h"
#include "discretization/surface/surface_geometry.h"

using namespace palpate;

namespace {

struct Fitted {
  NodeCloud cloud;
  BackgroundCells cells;
  std::vector<Vec3> before;
  double error_before = 0;
};

Fitted fit(const SurfaceTree& tree, double h) {
  SpacingField field;
  field.spacing = h;
  Fitted fitted;
  fitted.cloud = makeNodeCloud(tree, field, 1);
  fitted.cells = makeBackgroundCells(fitted.cloud, tree);
  fitted.before = fitted.cloud.X;
  fitted.error_before = fitted.cells.volumeError();
  fitToVolume(fitted.cloud, fitted.cells, tree);
  return fitted;
}

}  // namespace

TEST_CASE("Fitted cells hold the body's volume, by small moves of surface nodes", "[volume][whole]") {
  for (const bodies::Body& c : bodies::variedBodies()) {
    DYNAMIC_SECTION(c.name) {
      const SurfaceTree tree(c.surface);
      const Fitted fitted = fit(tree, c.h);
      CHECK(std::abs(fitted.error_before) < 0.04);  // chords of a surface with h / radius up to 0.3
      CHECK(std::abs(fitted.cells.volumeError()) < 5e-4);
      for (double volume : fitted.cells.volume) REQUIRE(volume > 0);
      for (std::size_t i = 0; i < fitted.before.size(); ++i) {
        const double moved = (fitted.cloud.X[i] - fitted.before[i]).norm();
        REQUIRE(moved <= (fitted.cloud.on_surface[i] ? 0.2 * c.h : 0.0));
      }
    }
  }
}

TEST_CASE("The loss on a sphere is 0.4 (h/r)^2 and the fit's remainder far below", "[volume][whole]") {
  // Chords of equilateral facets of edge h: mean gap h^2 / (8 r), times area over volume 3 / r.
  const double r = 0.05;
  const SurfaceTree tree(ellipsoidSurface({r, r, r}, 0.002));
  for (double h : {0.012, 0.008}) {
    const Fitted fitted = fit(tree, h);
    CHECK(fitted.error_before == Approx(-0.4 * h * h / (r * r)).epsilon(0.2));
    CHECK(std::abs(fitted.cells.volumeError()) < 0.01 * std::abs(fitted.error_before));
  }
}

TEST_CASE("A box does not move at all", "[volume]") {
  const Fitted fitted = fit(SurfaceTree(boxSurface({0.1, 0.08, 0.05}, 0.02)), 0.009);
  CHECK(fitted.cloud.X == fitted.before);
}

TEST_CASE("Nodes of a cylinder's flat ends stay in their plane", "[volume]") {
  const Fitted fitted = fit(SurfaceTree(cylinderSurface(0.04, 0.03, 0.004)), 0.01);
  int on_base = 0;
  for (std::size_t i = 0; i < fitted.before.size(); ++i) {
    if (std::abs(fitted.before[i].z()) > 1e-12) continue;
    ++on_base;
    REQUIRE(std::abs(fitted.cloud.X[i].z()) < 1e-12);  // regions choose nodes within 1e-9 m
  }
  CHECK(on_base > 50);
}

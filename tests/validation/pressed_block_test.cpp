#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "io/load_model.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

constexpr double young = 3000, edge = 0.03;

/// A block of about 360 nodes between plates without friction, the top going down linearly in `seconds` by a share of
/// its height; its sides confined, or two of them free.
Scene blockScene(double poisson, double compression, bool confined, double seconds) {
  Scene scene;
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3::Constant(edge);
  scene.discretization.spacing = 0.0055;
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", young);
  scene.materials[0].material.set("poisson", poisson);
  scene.tools[0].position = Vec3(0, 0, 1);
  scene.dynamics.damping = 60;
  scene.discretization.formulation.cell_volume = true;
  scene.boundaries = {test::roller(Vec3::Zero(), 2), test::roller(Vec3(0, 0, edge), 2)};
  scene.boundaries[1].translation = Vec3(0, 0, -compression * edge);
  scene.boundaries[1].duration = seconds;
  scene.boundaries[1].curve.kind = LoadCurve::Kind::Linear;
  for (int c = 0; c < 2; ++c)
    for (const double side : {-1.0, 1.0})
      if (confined || side < 0) scene.boundaries.push_back(test::roller(side * edge / 2 * Vec3::Unit(c), c));
  return scene;
}

/// Force on the top along z, N, of uniform stretches `along` z and `side` across:
///   P = mu J^(-2/3) (l - I1 / (3 l)) + K (J - 1) J / l
double stress(double poisson, double along, double other, double third) {
  const double mu = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
  const double J = along * other * third, I1 = along * along + other * other + third * third;
  return mu * std::pow(J, -2.0 / 3) * (along - I1 / (3 * along)) + K * (J - 1) * J / along;
}

double closedForm(double poisson, double compression, bool confined) {
  const double stretch = 1 - compression;
  double side = 1;
  if (!confined) {
    double low = 0.5, high = 3;  // the stress on the free side rises with its stretch
    for (int k = 0; k < 100; ++k) {
      side = (low + high) / 2;
      (stress(poisson, side, side, stretch) > 0 ? high : low) = side;
    }
  }
  return edge * edge * stress(poisson, stretch, side, side);
}

/// Compression at which the confined block's pressure is a multiple of its shear modulus.
double compressionFor(double poisson, double pressure_over_shear) {
  return pressure_over_shear * 3 * (1 - 2 * poisson) / (2 * (1 + poisson));
}

}  // namespace

TEST_CASE("Confined tissue meets the closed form at 5 to 40 shear moduli of pressure", "[validation][cell_volume]") {
  // Without the cells' volume it gives way at 4.5, with paired cells at 2.75: -24 % at 5, -53 % at 10, lost at 40.
  constexpr double nu = 0.499;
  struct Case {
    unsigned seed;
    double cells_per_point;
  };
  for (const Case& c : {Case{1, 1}, Case{2, 2}}) {
    Scene scene = blockScene(nu, compressionFor(nu, 40), true, 1);
    scene.discretization.seed = c.seed;
    scene.discretization.quadrature.cells_per_point = c.cells_per_point;
    const Model model = loadModel(scene);
    StaticSolver solver(model, 1, 1e-5);
    for (const double pressure : {5.0, 10.0, 40.0}) {
      INFO("seed " << c.seed << ", " << c.cells_per_point << " cells a point, " << pressure << " shear moduli");
      REQUIRE(solver.advanceTo(pressure / 40).converged);
      const double force = solver.body().reactions()[1].force.z();
      CHECK(force == Approx(closedForm(nu, compressionFor(nu, pressure), true)).epsilon(1e-3));
    }
  }
}

TEST_CASE("So it does in the loop, in float32", "[validation][cell_volume]") {
  constexpr double nu = 0.499;
  for (const double cells_per_point : {1.0, 2.0}) {
    Scene scene = blockScene(nu, compressionFor(nu, 40), true, 0.1);
    scene.discretization.seed = 3;
    scene.discretization.quadrature.cells_per_point = cells_per_point;
    const Model model = loadModel(scene);
    State state = initialState(model);
    Workspace workspace(model, 1);
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    double force = 0;
    constexpr int ticks = 150, measured = 50;
    for (int k = 0; k < ticks; ++k) {
      const StepReport report = tick(model, state, command, workspace);
      REQUIRE(report.flags == 0);
      CHECK(report.energy_error < 0.1);
      if (k >= ticks - measured) force += workspace.boundary.reaction[1].force.z() / measured;
    }
    CHECK(force == Approx(closedForm(nu, compressionFor(nu, 40), true)).epsilon(5e-3));
  }
}

TEST_CASE("A free block meets the closed form up to 50 % compression", "[validation][cell_volume]") {
  // A surface creases where the ratio of its stretches is 2.4, at 44 % (Hong, Zhao, Suo 2009): beyond that there is no
  // uniform solution to be close to for long. Where points keep no volume of their own (patch_stabilization = 0), some
  // clouds of nu 0.49 find no equilibrium at 45 %. At nu 0.45 volumes of points swing so far (0.4 to 1.6) that the
  // block gives way between 46 and 50 %, whatever the points keep. A barrier that begins just below the volume that it
  // has (0.94) holds them: at 50 % the force is 0.7 to 1 % too low with three clouds, and 45 to 63 % without it.
  // At nu 0.49 and 50 % it is 1.02 and 1.12 % too low since the areas of held nodes integrate the shape functions (it
  // was below 1 %); with thirds of facets, what is bent or twisted by its faces was 2 to 5 % too stiff.
  struct Case {
    double nu, compression, barrier_strength, barrier_J0;
    unsigned seed;
    double error;
  };
  for (const Case& c : {Case{0.45, 0.45, 0, 0.5, 1, 1e-2}, Case{0.45, 0.48, 5, 0.935, 1, 1e-2},
                        Case{0.49, 0.5, 0, 0.5, 2, 1.2e-2}, Case{0.49, 0.5, 0, 0.5, 3, 1.2e-2}}) {
    INFO("nu " << c.nu << ", " << c.compression << ", barrier " << c.barrier_strength << ", seed " << c.seed);
    Scene scene = blockScene(c.nu, c.compression, false, 1);
    scene.discretization.seed = c.seed;
    scene.materials[0].material.set("barrier_strength", c.barrier_strength);
    scene.materials[0].material.set("barrier_J0", c.barrier_J0);
    const Model model = loadModel(scene);
    StaticSolver solver(model, 1, 1e-5);
    for (const double share : {0.75, 1.0}) {
      REQUIRE(solver.advanceTo(share).converged);
      const double force = solver.body().reactions()[1].force.z();
      CHECK(force == Approx(closedForm(c.nu, c.compression * share, false)).epsilon(c.error));
    }
  }
}

TEST_CASE("A thin layer between bonded faces is as stiff as fine clouds say, also where cells hold the volume",
          "[validation][cell_volume]") {
  // A layer of 25 x 25 x 10 mm, nu 0.49, pressed by 20 %. Reference: the same with 7 spacings across its height,
  // without the cells' volume, 0.930 N (9 spacings: 0.919); with it, and all nodes' pressure bounded, four spacings
  // answer with 1.08 N.
  constexpr double height = 0.01, reference = 0.930;  // m, N
  Scene scene = blockScene(0.49, 0, false, 1);
  scene.organs[0].size = Vec3(2.5 * height, 2.5 * height, height);
  scene.discretization.spacing = height / 4;
  scene.boundaries.resize(2);
  for (BoundarySpec& b : scene.boundaries) std::fill(b.component, b.component + 3, true);
  scene.boundaries[1].region.point = Vec3(0, 0, height);
  scene.boundaries[1].translation = Vec3(0, 0, -0.2 * height);
  const Model model = loadModel(scene);
  StaticSolver solver(model, 1, 1e-4);
  REQUIRE(solver.advanceTo(1).converged);
  CHECK(-solver.body().reactions()[1].force.z() == Approx(reference).epsilon(0.02));
}

#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// The block held below and at its sides, so that it can only move up and down.
Scene columnScene(double young) {
  Scene scene = test::blockScene();
  scene.materials[0].material.set("young", young);
  scene.materials[0].material.set("poisson", 0.3);
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  scene.boundaries = {test::roller(Vec3::Zero(), 2)};
  for (const double side : {-0.03, 0.03})
    for (int c = 0; c < 2; ++c) scene.boundaries.push_back(test::roller(side * Vec3::Unit(c), c));
  return scene;
}

double weightOf(const Model& model) {
  double mass = 0;
  for (const double m : model.mass) mass += m;
  return 9.81 * mass;
}

}  // namespace

TEST_CASE("A column sags under its own weight as the closed form says", "[simulation][gravity]") {
  Scene scene = columnScene(3e5);
  scene.discretization.spacing = 0.009;
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 1, 1e-5);
  REQUIRE(solver.advanceTo(1).converged);
  // (K + 4/3 mu) u'' = rho g, u(0) = 0, u'(h) = 0; strains of 1e-3 are linear to a thousandth.
  const double M = model.materials[0].waveModulus(), h = 0.03;
  double sum = 0;
  for (std::size_t i = 0; i < model.X.size(); ++i) {
    Vec3 u = Vec3::Zero();
    for (int e = model.node_shape.begin[i]; e < model.node_shape.begin[i + 1]; ++e)
      u += model.node_shape.N[e] * toVec3(solver.body().u[model.node_shape.node[e]]);
    const double z = model.X[i].z(), expected = -1000 * 9.81 / M * (h * z - z * z / 2);
    sum += (u - Vec3(0, 0, expected)).squaredNorm();
  }
  // Of the top's sag; three cells to the height. mtled solves the same finer: 1 % at 6 mm.
  CHECK(std::sqrt(sum / static_cast<double>(model.X.size())) < 0.05 * 1000 * 9.81 / M * h * h / 2);
  CHECK(solver.body().reactions()[0].force.z() == Approx(weightOf(model)).epsilon(1e-3));
}

TEST_CASE("In the loop's step the base comes to bear the weight, and without gravity nothing",
          "[simulation][gravity]") {
  for (const bool heavy : {true, false}) {
    Scene scene = columnScene(2e4);
    scene.dynamics.damping = 150;
    if (!heavy) scene.dynamics.gravity.setZero();
    const Model model = test::blockModel(scene);
    CHECK(model.weight.empty() == !heavy);
    State state = initialState(model);
    Workspace workspace(model, 1);
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    command.tools[0].pose.position.z() += 0.1;
    state.tool[0].pose = command.tools[0].pose;
    StepReport report;
    for (int k = 0; k < 150; ++k) report = tick(model, state, command, workspace);
    CHECK(report.base_reaction.z() == Approx(heavy ? weightOf(model) : 0).epsilon(0.01).margin(1e-6));
    CHECK(report.flags == 0);
  }
}

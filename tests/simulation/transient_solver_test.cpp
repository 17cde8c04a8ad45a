#include <catch2/catch.hpp>
#include <cstring>

#include "batch/transient_solver.h"
#include "model/solution_fields.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;
using test::blockModel;
using test::blockScene;
using test::toolAt;

namespace {

/// The block shaken at its base and turned at its top.
Scene shaken() {
  Scene scene = blockScene();
  scene.boundaries.push_back(scene.boundaries[0]);
  scene.boundaries[1].region.point = Vec3(0, 0, 0.03);
  scene.boundaries[1].angle = 0.3;
  scene.boundaries[1].translation = Vec3(0.002, 0, 0.001);
  scene.boundaries[1].duration = 0.1;
  return scene;
}

double largest(const State& state) {
  double size = 0;
  for (const auto& u : state.u) size = std::max(size, toVec3(u).norm());
  return size;
}

double difference(const State& state, const BatchBody& body) {
  double worst = 0;
  for (std::size_t i = 0; i < state.u.size(); ++i)
    worst = std::max(worst, (toVec3(state.u[i]) - toVec3(body.u[i])).norm());
  return worst;
}

}  // namespace

TEST_CASE("The motion in double is that of the real-time loop in float", "[transient_solver]") {
  const Model model = blockModel(shaken());
  TransientSolver solver(model, 1);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = toolAt(model, -0.05);
  for (int k = 0; k < 100; ++k) {
    REQUIRE(tick(model, state, command, workspace).flags == 0);
    REQUIRE(solver.tick().finite);
  }
  CHECK(solver.step() == state.step);
  CHECK(solver.time() == Approx(100 / model.scene.dynamics.rate_hz).epsilon(1e-12));
  INFO("difference " << difference(state, solver.body()) << " of " << largest(state));
  CHECK(largest(state) > 0.005);
  // numerics.md: 1e-6 over 1e4 steps, for increments imposed on increments.
  CHECK(difference(state, solver.body()) < 1e-5 * largest(state));
}

TEST_CASE("Under a tool, too, double and float go the same way", "[transient_solver][contact]") {
  const Model model = blockModel();
  TransientSolver solver(model, 1);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  StepReport report;
  BatchBody::Report batch;
  for (int k = 1; k <= 100; ++k) {
    command.tools[0].pose = toolAt(model, (model.tools.first().first_contact_travel + 0.003) * LoadCurve{}.at(k, 100));
    report = tick(model, state, command, workspace);
    REQUIRE(report.flags == 0);
    batch = solver.tick(command.tools[0].pose);
    REQUIRE(batch.finite);
  }
  INFO("difference " << difference(state, solver.body()) << " of " << largest(state) << "; forces "
                     << report.tool_force.transpose() << " and " << batch.tool_force.transpose());
  CHECK(report.tool_force.z() > 0.01);
  CHECK((batch.tool_force - report.tool_force).norm() < 1e-3 * report.tool_force.norm());
  CHECK(difference(state, solver.body()) < 1e-4 * largest(state));  // contacts that begin a step apart
  CHECK(batch.min_J == Approx(report.min_J).epsilon(1e-4));
}

TEST_CASE("A transient solution that goes on from a saved state has the same future, to the bit",
          "[transient_solver][determinism]") {
  const Model model = blockModel(shaken());
  TransientSolver whole(model, 1), first(model, 2), second(model, 1);
  for (int k = 0; k < 20; ++k) whole.tick();
  for (int k = 0; k < 8; ++k) first.tick();
  second.resume(first.step(), first.body().u, first.body().du, {});
  for (int k = 8; k < 20; ++k) second.tick();
  CHECK(second.step() == whole.step());
  CHECK(std::memcmp(second.body().u.data(), whole.body().u.data(), whole.body().u.size() * sizeof(Double4)) == 0);
  CHECK(second.body().reactions()[1].force == whole.body().reactions()[1].force);
}

TEST_CASE("A tick that is interrupted between its steps never was", "[transient_solver]") {
  Scene scene = shaken();
  scene.dynamics.rate_hz = 100;
  const Model model = blockModel(scene);
  REQUIRE(model.substeps_per_tick > 4);
  TransientSolver solver(model, 1), unbroken(model, 1);
  for (int k = 0; k < 3; ++k) {
    solver.tick();
    unbroken.tick();
  }
  int calls = 0;
  CHECK_FALSE(solver.tick({}, [&] { return ++calls < 4; }).has_value());
  CHECK(calls == 4);
  CHECK(solver.step() == unbroken.step());
  CHECK(solver.time() == unbroken.time());
  const auto same = [&] {
    return std::memcmp(solver.body().u.data(), unbroken.body().u.data(), solver.body().u.size() * sizeof(Double4)) == 0;
  };
  CHECK(same());
  calls = 0;
  CHECK(solver.tick({}, [&] { return ++calls > 0; }).has_value());
  CHECK(calls == model.substeps_per_tick);
  unbroken.tick();
  CHECK(same());
}

TEST_CASE("A batch body's forces are the reference kernel's, and fieldAt sums N u", "[batch_body]") {
  const Model model = blockModel();
  BatchBody body(model, model.mass, 2);
  std::vector<Vec3> u, f;
  AlignedVector<Double4> u4, f4(model.X.size());
  for (const auto& x : model.X) {
    u.push_back(0.003 * Vec3(std::sin(80 * x.z()), std::cos(50 * x.x()), std::sin(60 * x.y())));
    u4.push_back(toReal4<double>(u.back()));
  }
  body.forces(u4, f4);
  referenceInternalForces(model.point_shape, model.point_volume, model.point_material, model.materials, u, f,
                          model.patches);
  double worst = 0, size = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    worst = std::max(worst, (toVec3(f4[i]) - f[i]).norm());
    size = std::max(size, f[i].norm());
  }
  CHECK(worst < 1e-12 * size);  // rounding times K/mu

  ShapeTable shape;
  shape.begin = {0, 2, 3};
  shape.node = {4, 7, 5};
  shape.N = {0.25, 0.75, 2};
  const auto field = fieldAt(shape, u4);
  REQUIRE(field.size() == 2);
  CHECK((field[0] - (0.25 * u[4] + 0.75 * u[7])).norm() < 1e-18);
  CHECK((field[1] - 2 * u[5]).norm() < 1e-18);
}

TEST_CASE("A uniform strain has uniform fields: displacement, J, pressure, von Mises", "[solution_fields][whole]") {
  Mat3 F;
  F << 1.1, 0.1, 0, 0.02, 0.95, 0.05, -0.1, 0, 1.02;
  for (const bool patches : {false, true})
    for (const int points : {1, 4}) {
      Scene scene = blockScene();
      scene.discretization.formulation.node_patches = patches;
      scene.discretization.quadrature.points_per_cell = points;
      const Model model = blockModel(scene);
      std::vector<Vec3> u;
      for (const auto& x : model.X) u.push_back((F - Mat3::Identity()) * x);
      const SolutionFields fields = solutionFields(model, u);
      REQUIRE(fields.displacement.size() == model.X.size());
      REQUIRE(fields.J.size() == model.cells.size());
      double worst = 0;
      for (std::size_t i = 0; i < u.size(); ++i) worst = std::max(worst, (fields.displacement[i] - u[i]).norm());
      CHECK(worst < 1e-12);  // linear reproduction
      const double J = F.determinant();
      const Mat3 P = model.materials[0].firstPiola(F), cauchy = P * F.transpose() / J;
      const Mat3 deviator = cauchy - cauchy.trace() / 3 * Mat3::Identity();
      const double mises = std::sqrt(1.5 * deviator.squaredNorm());
      for (std::size_t c = 0; c < fields.J.size(); ++c) {
        // Linear consistency to 1e-10 (consistent gradients keep it); the bulk modulus multiplies it.
        REQUIRE(fields.J[c] == Approx(J).epsilon(1e-9));
        REQUIRE(fields.pressure[c] == Approx(-cauchy.trace() / 3).epsilon(1e-7));
        REQUIRE(fields.von_mises[c] == Approx(mises).epsilon(1e-7));
      }
      std::vector<Mat3> gradients;
      const auto stresses = pointStresses(model, u, gradients);
      for (int q = 0; q < model.pointCount(); ++q) {
        REQUIRE((gradients[q] - F).norm() < 1e-9);
        REQUIRE((stresses[q] - P).norm() < 1e-7 * P.norm());
      }
    }
}

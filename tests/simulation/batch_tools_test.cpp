// Several tools, and jaws, in static and transient solutions.

#include "batch/batch_tools.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "batch/transient_solver.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/squeezed_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

constexpr double pressed_depth = 0.003;  // m

ToolsAt fingers(const Model& model, double deep) {
  const Command command = fingersAt(model, deep);
  ToolsAt tools;
  tools.count = 2;
  tools.posture = command.tools;
  tools.posture[0].pose = command.tools[0].pose;
  return tools;
}

}  // namespace

TEST_CASE("Two fingers that squeeze a block are in balance, and feel what they feel in the loop", "[tools][whole]") {
  Scene scene = squeezedScene();
  scene.tools[0].friction = scene.tools[1].friction = 0;
  const Model model = blockModel(scene);
  StaticSolver solver(model, 1, 1e-4);
  Equilibrium rest;
  for (int k = 1; k <= 4; ++k) {
    rest = solver.advanceTo(0.25 * k, fingers(model, 0.25 * k * pressed_depth));
    REQUIRE(rest.converged);
  }
  const double right = rest.loads[0].force.x(), left = rest.loads[1].force.x();
  CHECK(right > 0.05);  // N
  CHECK(std::abs(right + left) < 0.01 * right);
  CHECK(rest.tool_force == rest.loads[0].force);
  CHECK(rest.loads[0].contact_count > 3);
  CHECK(rest.loads[1].contact_count > 3);

  State state = initialState(model);
  Workspace workspace(model, 1);
  StepReport held;
  constexpr int press = 150, hold = 250;
  for (int k = 1; k <= press + hold; ++k)
    held = tick(model, state, fingersAt(model, pressed_depth * std::min(1.0, double(k) / press)), workspace);
  CHECK(held.loads[0].force.x() == Approx(right).epsilon(0.02));
  CHECK(held.loads[1].force.x() == Approx(left).epsilon(0.02));
}

TEST_CASE("A motion in double under two fingers is that of the loop", "[tools]") {
  const Model model = blockModel(squeezedScene());
  TransientSolver solver(model, 1);
  State state = initialState(model);
  Workspace workspace(model, 1);
  StepReport loop;
  BatchBody::Report batch;
  constexpr int press = 40;
  for (int k = 1; k <= press; ++k) {
    const double deep = pressed_depth * k / press;
    loop = tick(model, state, fingersAt(model, deep), workspace);
    batch = solver.tick(fingers(model, deep));
  }
  REQUIRE(loop.loads[0].force.x() > 0.05);  // N
  for (const std::size_t t : {0, 1}) {
    // Float beside double, and mass that the loop adds where the tissue is squeezed.
    CHECK((batch.loads[t].force - loop.loads[t].force).norm() < 0.01 * loop.loads[t].force.norm());
  }
}

TEST_CASE("Tools go evenly between two places, and only those that are wanted", "[tools]") {
  ToolsAt from, to;
  from.count = to.count = 2;
  to.posture[1].pose.position = Vec3(0.01, 0, 0);
  to.posture[1].opening = 0.004;
  from.posture[1].opening = 0.002;
  const ToolsAt half = between(from, to, 0.5);
  CHECK(half.count == 2);
  CHECK(half.posture[1].pose.position == Vec3(0.005, 0, 0));
  CHECK(half.posture[1].opening == Approx(0.003));
  CHECK_FALSE(ToolsAt(std::nullopt));
  CHECK(ToolsAt(Pose()).count == 1);
}

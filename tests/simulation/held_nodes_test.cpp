#include "step/held_nodes.h"

#include <catch2/catch.hpp>
#include <cstdio>

#include "batch/transient_solver.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// A layer that is bonded to its base and thinner than its supports are wide, under a ball that does not slip easily.
Scene thinLayer() {
  Scene scene = test::blockScene(0.004);
  scene.organs[0].size = Vec3(0.05, 0.04, 0.006);
  scene.materials[0].material.set("poisson", 0.45);
  scene.tools[0].position = Vec3(0.002, 0, 0.0061);
  scene.tools[0].friction = 0.8;
  return scene;
}

}  // namespace

TEST_CASE("A ball held in a thin bonded layer with friction feels the same for seconds", "[simulation][contact]") {
  const Scene scene = thinLayer();
  const Model model = buildModel(scene, boxSurface(scene.organs[0].size, 0.002));
  Workspace workspace(model, 1);
  State state = initialState(model);
  Command command = restCommand(model);
  StepReport report;
  const auto ticks = [&](int count) {
    for (int k = 0; k < count; ++k) report = tick(model, state, command, workspace);
    return report;
  };
  for (int k = 1; k <= 100; ++k) {
    command.tools[0].pose = test::toolAt(model, 0.0025 * k / 100);
    ticks(1);
  }
  const StepReport early = ticks(200);
  const StepReport late = ticks(1500);
  std::printf("held in a thin layer: %.4f N, 3 s later %.4f N\n", early.tool_force.z(), late.tool_force.z());
  CHECK(late.tool_force.z() == Approx(early.tool_force.z()).epsilon(2e-3));
  CHECK(late.strain_energy == Approx(early.strain_energy).epsilon(2e-3));
  CHECK((late.tool_force - late.base_reaction).norm() < 1e-3 * late.tool_force.norm());  // both times' tractions
  CHECK(touchesBesideHeld(model, state.contact, state.skins, state.rigid));
}

TEST_CASE("In double the same layer feels the same, too", "[simulation][contact]") {
  const Scene scene = thinLayer();
  const Model model = buildModel(scene, boxSurface(scene.organs[0].size, 0.002));
  TransientSolver motion(model, 1);
  const auto press = [&](double depth) {
    ToolsAt tools;
    tools.count = 1;
    tools.posture[0].pose = test::toolAt(model, depth);
    return motion.tick(tools);
  };
  BatchBody::Report report;
  for (int k = 1; k <= 100; ++k) report = press(0.0025 * k / 100);
  for (int k = 0; k < 200; ++k) report = press(0.0025);
  const double early = report.tool_force.z();
  for (int k = 0; k < 1000; ++k) report = press(0.0025);
  CHECK(report.tool_force.z() == Approx(early).epsilon(2e-3));
}

#include "step/tool_contact.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "batch/static_solver.h"
#include "contact/tools/tool_list.h"
#include "model/live_parameters.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// N, of the first tool that is pressed in and held. @param live  in place of what was loaded, or null
double pressedForce(const Scene& scene, double depth, const Material* live = nullptr) {
  const Model model = test::blockModel(scene);
  Workspace workspace(model, 2);
  State state = initialState(model);
  if (live != nullptr) setMaterial(model, 0, *live, state);
  const double touch = model.tools.first().first_contact_travel;
  const auto travelAt = [&](int k) { return touch + depth * std::min(1.0, k / 100.0); };
  return test::moveAlong(model, state, workspace, 200, travelAt).tool_force.norm();
}

}  // namespace

TEST_CASE("What is soft elsewhere, and a tool that is small, are not felt through the contact's layer",
          "[tool_contact][whole]") {
  Scene scene = test::blockScene(0.006);
  scene.materials[0].material.set("young", 1e5);
  const double alone = pressedForce(scene, 0.001);
  scene.materials.push_back(scene.materials[0]);
  MaterialSpec& cyst = scene.materials[1];
  cyst.everywhere = false;
  cyst.region.kind = Region::Kind::Sphere;
  cyst.region.point = Vec3(-0.022, -0.022, 0.008);
  cyst.region.radius = 0.007;
  cyst.material.set("young", 300);
  CHECK(pressedForce(scene, 0.001) == Approx(alone).epsilon(0.005));  // was half of it

  Scene wide = test::blockScene(0.006);  // a fifth of what it pressed was in the layer
  wide.tools[0].shape.radius = 0.3;
  wide.tools[0].position.z() = 0.031;
  const double by_one = pressedForce(wide, 0.001);
  wide.tools.push_back(wide.tools[0]);
  wide.tools[1].shape.radius = 0.004;
  wide.tools[1].position = Vec3(0, 0, 0.7);
  CHECK(pressedForce(wide, 0.001) == Approx(by_one).epsilon(0.01));
}

TEST_CASE("Tissue that is made stiffer live is touched as if it had been loaded so", "[tool_contact]") {
  Scene scene = test::blockScene();
  scene.dynamics.time_step = 5e-5;  // both have room in it
  Scene stiff = scene;
  stiff.materials[0].material.set("young", 1.5e5);
  const Material material = test::blockModel(stiff).materials[0];
  CHECK(pressedForce(scene, 0.001, &material) == Approx(pressedForce(stiff, 0.001)).epsilon(0.01));
}

TEST_CASE("What the wall behind a sharp rim drags along is no force to be trusted", "[tool_contact][whole]") {
  // Frictionless and elastic, so slid or not a flat end feels nothing aside.
  Scene scene = test::blockScene(0.004);
  scene.organs[0].size = Vec3(0.06, 0.04, 0.02);
  scene.materials[0].material.set("poisson", 0.45);
  scene.tools[0].shape = ToolShape::of(ToolKind::FlatCylinder, 0.01);
  scene.tools[0].position = Vec3(-0.007, 0, 0.021);
  for (const double rim : {0.0003, 0.003}) {
    scene.tools[0].shape.parameter[0] = rim;
    const Model model = test::blockModel(scene);
    Workspace workspace(model, 2);
    State state = initialState(model);
    Command command = restCommand(model);
    StepReport report;
    for (int k = 1; k <= 500; ++k) {
      command.tools[0].pose =
          test::toolAt(model, model.tools.first().first_contact_travel + 0.002 * std::min(1.0, k / 150.0));
      command.tools[0].pose.position.x() += 0.004 * std::clamp((k - 150) / 200.0, 0.0, 1.0);
      report = tick(model, state, command, workspace);
    }
    const double aside = std::abs(report.tool_force.x()) / report.tool_force.norm();
    INFO("rim " << rim << ", aside " << aside << ", expected " << report.expected_error);
    CHECK(report.expected_error > 0.7 * aside);
    CHECK((aside > 0.1) == (rim < 0.001));
    CHECK((rimForce(model, state, 0) > 0) == (rim < 0.001));
    CHECK((report.expected_error > 0.1) == (rim < 0.001));
  }
}

TEST_CASE("In equilibria, too, what a sharp rim drags along is in the error to expect",
          "[tool_contact][static][whole]") {
  Scene scene = test::blockScene(0.004);
  scene.organs[0].size = Vec3(0.06, 0.04, 0.02);
  scene.materials[0].material.set("poisson", 0.45);
  scene.tools[0].shape = ToolShape::of(ToolKind::FlatCylinder, 0.01);
  scene.tools[0].shape.parameter[0] = 0.0003;
  scene.tools[0].position = Vec3(-0.007, 0, 0.021);
  const Model model = test::blockModel(scene);
  StaticSolver solver(model, 2, 1e-3);
  Equilibrium equilibrium;
  for (int k = 0; k <= 8; ++k) {
    Pose pose = test::toolAt(model, model.tools.first().first_contact_travel + 0.002);
    pose.position.x() += 0.0005 * k;
    equilibrium = solver.advanceTo(0, pose);
  }
  const double aside = std::abs(equilibrium.tool_force.x()) / equilibrium.tool_force.norm();
  INFO("aside " << aside << ", expected " << equilibrium.expected_error);
  CHECK(aside > 0.1);
  CHECK(equilibrium.expected_error > 0.7 * aside);
}

TEST_CASE("A tool's work counts what a hand swings within a tick", "[tool_contact]") {
  // Pressed 4 mm in, then swung by 0.3 mm at 200 Hz: the same way and steps, told 500 or 2000 times a second.
  const auto depthAt = [](double tick) {
    return 0.004 * std::min(1.0, tick / 100) + (tick > 100 ? 0.0003 * std::sin(2 * M_PI * 0.4 * tick) : 0);
  };
  const auto workOf = [&](int parts) {
    Scene scene = test::blockScene();
    scene.dynamics.rate_hz = 500 * parts;
    scene.dynamics.time_step = 5e-4;
    const Model model = test::blockModel(scene);
    Workspace workspace(model, 1);
    State state = initialState(model);
    Command command = restCommand(model);
    double work = 0;
    for (int k = 1; k <= 200 * parts; ++k) {
      const int knot = (k - 1) / parts;
      const double share = static_cast<double>(k - knot * parts) / parts;
      const double depth = (1 - share) * depthAt(knot) + share * depthAt(knot + 1);
      command.tools[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + depth);
      work += tick(model, state, command, workspace).loads[0].work;
    }
    return work;
  };
  const double told_often = workOf(4);
  CHECK(told_often > 0);
  CHECK(workOf(1) == Approx(told_often).epsilon(0.01));
}

TEST_CASE("Without friction a sphere's forces pass through its centre: the torque about its tip is known",
          "[tool_contact]") {
  const Model model = test::blockModel();
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  StepReport report;
  constexpr int ticks = 60;
  const Quat tilted(Eigen::AngleAxisd(0.5, Vec3(1, 2, 0).normalized()));
  for (int k = 1; k <= ticks; ++k) {
    command.tools[0].pose = test::toolAt(model, model.tools.first().first_contact_travel + 0.003 * k / ticks);
    command.tools[0].pose.orientation = tilted;
    report = tick(model, state, command, workspace);
  }
  const Vec3 force = report.tool_force;
  REQUIRE(force.z() > 0);
  const Vec3 centre = tilted * Vec3(0, 0, model.scene.tools[0].shape.radius);  // from the tip
  const Vec3 expected = centre.cross(force);
  // The positions are those after the step, the normals those before it.
  CHECK((report.tool_torque - expected).norm() < 0.02 * expected.norm());
  CHECK(report.contact_normal.norm() == Approx(1));
  CHECK(report.contact_normal.dot(force.normalized()) > 0.999);

  Vec3 sum = Vec3::Zero();
  forEachContactForce(state.contact[0], [&](int, const Float4& f) { sum -= toVec3(f); });
  CHECK((sum - force).norm() < 1e-5 * force.norm());

  command.tools[0].pose = model.tools.first().start.pose;
  for (int k = 0; k < 20; ++k) report = tick(model, state, command, workspace);
  CHECK(report.tool_torque.isZero(0));
  CHECK(report.contact_normal.isZero(0));
}

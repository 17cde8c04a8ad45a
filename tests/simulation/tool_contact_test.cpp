#include "step/tool_contact.h"

#include <catch2/catch.hpp>

#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

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

#include "step/rigid_stop.h"

#include <catch2/catch.hpp>

#include "contact/tools/tool_list.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/small_scene.h"

using namespace palpate;

namespace {

/// A ball of 10 mm, or another tool, before one rigid body.
Scene toolBefore(Region::Kind kind) {
  Scene scene = test::blockScene();
  RigidSpec body;
  body.name = "body";
  body.region.kind = kind;
  body.region.point = Vec3(0.2, 0, 0);
  body.region.radius = 0.03;
  body.region.min = Vec3(0.15, -0.05, -0.02);
  body.region.max = Vec3(0.25, 0.05, 0);
  scene.rigid = {body};
  return scene;
}

constexpr double kept = 0.25 * 0.01;  // m, of the radius

}  // namespace

TEST_CASE("A tool comes to stand before a rigid body and slides along it", "[simulation][rigid]") {
  Pose pose;
  SECTION("a ball over a box") {
    const Model model = test::blockModel(toolBefore(Region::Kind::Box));
    pose.position = Vec3(0.2, 0.01, -0.001);
    const Pose stopped = stoppedByRigidBodies(model, 0, {pose, 0}, 0, 1).pose;
    CHECK((stopped.position - Vec3(0.2, 0.01, kept)).norm() < 1e-9);
    const Pose short_of = stoppedByRigidBodies(model, 0, {pose, 0}, 0, 0.0005).pose;
    CHECK(short_of.position.z() == Approx(-0.0005));
    pose.position.z() = 0.01;
    CHECK(stoppedByRigidBodies(model, 0, {pose, 0}, 0, 1).pose.position == pose.position);  // to the bit
  }
  SECTION("a ball beside a ball") {
    const Model model = test::blockModel(toolBefore(Region::Kind::Sphere));
    pose.position = Vec3(0.215, 0, 0.015);
    const Vec3 middle = stoppedByRigidBodies(model, 0, {pose, 0}, 0, 1).pose.position + Vec3(0, 0, 0.01);
    CHECK((middle - Vec3(0.2, 0, 0)).norm() == Approx(0.04 + kept));
  }
  SECTION("a capsule that lies, the middle of its side first") {
    Scene scene = toolBefore(Region::Kind::Sphere);
    scene.tools[0].shape = ToolShape::of(ToolKind::Capsule, 0.01, 0.08);
    const Model model = test::blockModel(scene);
    pose.orientation = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY());
    pose.position = Vec3(0.2, -0.042, 0.035);
    const Vec3 at = stoppedByRigidBodies(model, 0, {pose, 0}, 0, 1).pose.position;
    CHECK(at.z() == Approx(0.04 + kept).margin(2e-4));
  }
}

TEST_CASE("A tool under a hand that goes through the table does not, nor does the tissue",
          "[simulation][rigid][whole]") {
  Scene scene = test::blockScene();
  scene.boundaries.clear();
  scene.dynamics.gravity = Vec3(0, 0, -9.81);
  RigidSpec table;
  table.name = "table";
  table.friction = 0.5;
  scene.rigid = {table};
  scene.tools[0].max_speed = 0.3;
  const Model model = test::blockModel(scene);
  State state = initialState(model);
  Workspace workspace(model, 1);
  Command command;
  command.tools[0].pose = test::toolAt(model, 0.08);
  std::uint32_t flags = 0;
  StepReport report;
  for (int k = 0; k < 250; ++k) flags |= (report = tick(model, state, command, workspace)).flags;
  CHECK(report.loads[0].stopped);
  CHECK((flags & (kNotFinite | kBlowUp)) == 0);
  CHECK(state.tool[0].pose.position.z() > 0.9 * kept);
  double lowest = 0;
  for (int v = 0; v < model.skin.vertexCount(); ++v)
    lowest = std::min(lowest, skinPosition(model.skin, v, state.u.data()).z());
  CHECK(lowest > -2e-3);  // between the points that touch, which are half a spacing apart
}

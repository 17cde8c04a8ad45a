// Several tools at once, and jaws.

#include "step/tool_bodies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "model/model_hash.h"
#include "step/step.h"
#include "step/workspace.h"
#include "support/squeezed_scene.h"
#include "support/strip_scene.h"
#include "support/temp_folder.h"

using namespace palpate;
using namespace palpate::test;

TEST_CASE("Two fingers that squeeze a block feel equal and opposite forces", "[tools][whole]") {
  const Model model = blockModel(squeezedScene());
  REQUIRE(model.tools.toolCount() == 2);
  State state = initialState(model);
  Workspace workspace(model, 1);
  StepReport report;
  constexpr int press = 150, hold = 250;
  for (int k = 1; k <= press + hold; ++k)
    report = tick(model, state, fingersAt(model, 0.004 * std::min(1.0, double(k) / press)), workspace);
  CHECK(report.flags == 0);
  const Vec3 right = report.loads[0].force, left = report.loads[1].force;
  CHECK(report.tool_force == right);
  CHECK(right.x() > 0.05);  // N
  CHECK(std::abs(right.x() + left.x()) < 0.01 * right.x());
  CHECK(report.loads[0].contact_count > 3);
  CHECK(report.loads[1].contact_count > 3);
  CHECK(report.loads[1].pinch == 0);  // no jaws

  // Against what each of them feels where the other holds the block alone: together they press as deep as one of them
  // that goes twice as far, for a block that is free to slide.
  State one = initialState(model);
  StepReport alone;
  for (int k = 1; k <= press + hold; ++k) {
    Command command = restCommand(model);
    const double share = std::min(1.0, double(k) / press);
    command.tools[0].pose.position.x() -= 0.003 + 0.008 * share;
    command.tools[1].pose.position.x() += 0.003;
    alone = tick(model, one, command, workspace);
  }
  CHECK(alone.tool_force.x() == Approx(right.x()).epsilon(0.05));
}

TEST_CASE("Jaws that lift a strip carry its weight and do not lose it", "[tools][whole]") {
  const Model model = stripModel();
  REQUIRE(model.tools.bodyCount() == 3);
  State state = initialState(model);
  Workspace workspace(model, 1);
  const double rate = model.scene.dynamics.rate_hz;
  const double weight = stripWeight(model);
  CHECK(weight == Approx(1050 * 9.81 * 0.008 * 0.03 * 0.024).epsilon(0.01));
  StepReport report;
  std::uint32_t flags = 0;
  double on_table = 0, lifted = 0, pinch = 0, height = 0;
  int samples = 0;
  const int held = static_cast<int>(1.15 * rate), end = static_cast<int>(1.35 * rate);
  const auto top = [&] {  // m, the highest point of the skin
    double z = -1;
    for (int v = 0; v < model.skin.vertexCount(); ++v) z = std::max(z, skinPosition(model.skin, v, state.u.data()).z());
    return z;
  };
  for (int k = 1; k <= end; ++k) {
    Command command = restCommand(model);
    const ToolPosture jaws = graspAndLift(model, k / rate);
    command.tools[0].pose = jaws.pose;
    command.tools[0].opening = jaws.opening;
    report = tick(model, state, command, workspace);
    flags |= report.flags;
    if (k == static_cast<int>(0.2 * rate)) on_table = -report.loads[1].force.z();
    if (k == held) height = top();
    if (k <= held) continue;
    lifted -= report.loads[0].force.z();
    pinch += report.loads[0].pinch;
    ++samples;
  }
  CHECK((flags & (kNotFinite | kBlowUp)) == 0);
  CHECK(on_table == Approx(weight).epsilon(0.05));  // it still swings a little
  CHECK(lifted / samples == Approx(weight).epsilon(0.02));
  CHECK(report.loads[1].contact_count == 0);
  CHECK(0.8 * 2 * pinch / samples > weight);  // what friction can hold at this pinch
  CHECK(std::abs(top() - height) < 1e-4);     // it does not slip out
  CHECK(height > 0.024 + 0.008);              // lifted by 10 mm, less what it hangs down
  CHECK(state.tool[0].opening == Approx(0.005));
}

TEST_CASE("Several tools have the same bits on any number of threads", "[tools][whole]") {
  const Model model = stripModel();
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 3}) {
    State state = initialState(model);
    Workspace workspace(model, threads);
    workspace.team.wake();
    for (int k = 1; k <= 60; ++k) {
      Command command = restCommand(model);
      const ToolPosture jaws = graspAndLift(model, 0.3 + k / model.scene.dynamics.rate_hz);
      command.tools[0].pose = jaws.pose;
      command.tools[0].opening = jaws.opening;
      tick(model, state, command, workspace);
    }
    workspace.team.park();
    hashes.push_back(stateHash(model, state));
  }
  CHECK(hashes[1] == hashes[0]);
}

TEST_CASE("The state's hash has the further tools' poses, openings and contacts", "[tools]") {
  const Model model = stripModel();
  State state = initialState(model);
  const std::uint64_t rest = stateHash(model, state);
  state.tool[0].opening += 1e-9;
  CHECK(stateHash(model, state) != rest);
  state = initialState(model);
  state.tool[1].pose.position.x() += 1e-9;
  CHECK(stateHash(model, state) != rest);
  state = initialState(model);
  state.contact[2].count = 1;
  CHECK(stateHash(model, state) != rest);
}

TEST_CASE("A finger stands half the opening and its radius beside the middle of its jaws", "[tools]") {
  const ToolBody finger{0, 1, ToolShape::of(ToolKind::Capsule, 0.004, 0.03)};
  const Pose turned{Vec3(1, 2, 3), Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()))};
  const Pose pose = bodyPose(finger, {turned, 0.012});
  CHECK((pose.position - Vec3(1, 2.01, 3)).norm() < 1e-12);
  CHECK(pose.orientation.coeffs() == turned.orientation.coeffs());
}

TEST_CASE("A tool that starts in the organ is told by its number", "[tools][whole]") {
  Scene scene = stripScene();
  scene.tools[1].position.z() = 0.005;
  CHECK_THAT(refusal([&] { stripModel(scene); }), Catch::Contains("tool 2 starts inside the organ"));
  scene = stripScene();
  scene.tools[0].opening = 0.006;
  CHECK_THAT(refusal([&] { stripModel(scene); }),
             Catch::Contains("tool 1 starts inside the organ") && Catch::Contains("opening"));
}

#include "realtime/loop/snag_watch.h"

#include <catch2/catch.hpp>

#include "contact/tools/tool_list.h"
#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"

using namespace palpate;

namespace {

/// 100 x 60 x 40 mm in the corners of its skin.
Model boxed() {
  Model model = test::smallModel(500);
  model.skin.surface.vertices = {Vec3(0, 0, 0), Vec3(0.1, 0.06, 0.04)};
  model.tools.first().shape = ToolShape::of(ToolKind::Sphere, 0.005);
  model.tools.first().start.pose.position = Vec3(0.05, 0.03, 0.042);
  return model;
}

StepReport touching() {
  StepReport report;
  report.contact_count = report.loads[0].contact_count = 3;
  return report;
}

/// The ticks after which `watch` finds a tool at `tip` caught; -1: not within 2000.
int ticksUntilFound(SnagWatch& watch, const Model& model, const Vec3& tip, const Vec3& hand, const StepReport& report) {
  State state = test::FakePhysics(model).state();
  state.tool[0].pose.position = tip;
  for (int t = 1; t <= 2000; ++t)
    if (watch.update(state, hand, report)) return t;
  return -1;
}

}  // namespace

TEST_CASE("A tool that touches far outside of the body is caught", "[snag_watch]") {
  Model model = boxed();
  SnagWatch watch(model);
  const double far = SnagWatch::far_outside * Vec3(0.1, 0.06, 0.042).norm() + 0.01;
  const Vec3 above(0.05, 0.03, 0.042 + far + 1e-6), beside(0.1 + far + 1e-6, 0.03, 0.02), near(0.05, 0.03, 0.04 + far);
  CHECK(ticksUntilFound(watch, model, above, above, touching()) == 250);
  CHECK(ticksUntilFound(watch, model, above, above, touching()) == 250);  // and anew
  CHECK(ticksUntilFound(watch, model, beside, beside, touching()) == 250);
  CHECK(ticksUntilFound(watch, model, near, near, touching()) == -1);
  CHECK(ticksUntilFound(watch, model, above, above, StepReport()) == -1);  // it touches nothing
  // A hand that draws harder than the tissue bears; one that presses deep, below the body.
  CHECK(ticksUntilFound(watch, model, Vec3(0.05, 0.03, 0.06), above, touching()) == 250);
  CHECK(ticksUntilFound(watch, model, Vec3(0.05, 0.03, 0.002), Vec3(0.05, 0.03, -1), touching()) == -1);
  State state = test::FakePhysics(model).state();
  state.tool[0].pose.position = above;
  int found = 0;
  for (int t = 1; t <= 750; ++t) found += watch.update(state, above, t % 3 == 0 ? touching() : StepReport());
  CHECK(found == 1);  // a fold that swings touches now and then
  model.tools.first().shape = ToolShape::of(ToolKind::FlatCylinder, 0.005, 0.05);
  SnagWatch longer(model);  // its side may touch the body
  CHECK(ticksUntilFound(longer, model, above, above, touching()) == -1);
  model.scene.boundaries.emplace_back();
  model.scene.boundaries.back().duration = 1;
  SnagWatch moved(model);  // a body that is moved may be anywhere
  CHECK(ticksUntilFound(moved, model, Vec3(1, 1, 1), Vec3(1, 1, 1), touching()) == -1);
}

TEST_CASE("What a tool carries off is told from a body that it pushes along, and of each tool by itself",
          "[snag_watch]") {
  Model model = boxed();
  model.imposed = {4, 4, 4, 4};  // on ice
  SnagWatch on_ice(model);
  State state = test::FakePhysics(model).state();
  const Vec3 away(0.3, 0.03, 0.02);
  const auto found = [&](SnagWatch& watch, float slid, const StepReport& report) {
    for (Float4& u : state.u) u = {slid, 0, 0, 0};
    for (ToolPosture& tool : state.tool) tool.pose.position = away;
    int count = 0;
    for (int t = 1; t <= 250; ++t) count += watch.update(state, away, report);
    return count == 1;
  };
  CHECK(found(on_ice, 0, touching()));
  CHECK_FALSE(found(on_ice, 0.25F, touching()));  // the body is there, too
  model.tools.tool = {model.tools.first(), model.tools.first()};
  state.tool.resize(2);
  StepReport second;
  second.loads[1].contact_count = 1;
  SnagWatch of_first(model, 0), of_second(model, 1);
  CHECK_FALSE(found(of_first, 0, second));
  CHECK(found(of_second, 0, second));
  model.tools.tool[1].jaws = true;
  SnagWatch jaws(model, 1);
  CHECK_FALSE(found(jaws, 0, second));
}

TEST_CASE("A tool that stands between skin before it and behind, far from its hand, is stuck", "[snag_watch]") {
  const Model model = boxed();
  SnagWatch watch(model);
  State state = test::FakePhysics(model).state();
  Vec3 hand(0.05, 0.03, -1);
  const auto ticksUntil = [&](double below, double above, double speed) {  // N from either side; m/s
    state.contact[0].vertex = {0, 1};
    state.contact[0].force = {Float4{0, 0, static_cast<float>(-below), 0}, Float4{0, 0, static_cast<float>(above), 0}};
    state.contact[0].count = 2;
    state.tool[0].pose.position = Vec3(0.05, 0.03, 0.02);
    for (int t = 1; t <= 5000; ++t) {
      state.tool[0].pose.position.z() -= speed / model.scene.rate_hz;
      if (watch.update(state, hand, touching())) return t;
    }
    watch.recall({});
    return -1;
  };
  const int stuck = static_cast<int>(SnagWatch::stuck_seconds * model.scene.rate_hz);
  CHECK(ticksUntil(5, 2, 0) == stuck);
  CHECK(ticksUntil(5, 2, 0) == stuck);  // and anew
  CHECK(ticksUntil(5, 8, 0) == stuck);  // held by what is behind it
  CHECK(ticksUntil(5, 1, 0) == -1);     // it presses
  CHECK(ticksUntil(5, 2, 2e-3) == -1);  // it gets on, if slowly
  hand.z() = -0.01;
  CHECK(ticksUntil(5, 2, 0) == -1);  // the hand is near
}

TEST_CASE("A tool that is caught lets go, is told of, goes to its hand, and touches again once it is clear",
          "[snag_watch]") {
  const Model model = boxed();
  test::FakePhysics physics(model);
  const Vec3 out(0.05, 0.03, 1);
  Vec3 at(0.05, 0.03, 0.2);
  std::vector<std::int64_t> free_ticks;
  physics.on_tick = [&](State& state, StepReport& report) {
    if (state.tick < 100) return;
    const Command& command = physics.last_command;
    if (command.lets_go[0]) {
      CHECK(command.tools[0].pose.position == out);  // wherever the hand is by now
      free_ticks.push_back(state.tick);
      at.z() += 0.002;
      report.loads[0].near_count = at.z() < 0.2505;
    } else if (free_ticks.empty()) {
      report.contact_count = report.loads[0].contact_count = report.loads[0].near_count = 3;
    }
    state.tool[0].pose.position = at;
    state.u[0].x = 0.05F;
  };
  SimulationLoopOptions options;
  options.tick_limit = 450;
  SimulationLoop loop(model, physics, nullptr, options);
  Pose hand;
  hand.position = out;
  loop.commands().push(Request::moveTool(hand));
  test::FakeClock clock;
  loop.run(clock);
  CHECK(loop.summary().let_go_count == 1);
  CHECK(loop.summary().restored_count == 0);
  CHECK(physics.state().u[0].x == 0.05F);  // the tissue is left to itself
  REQUIRE(free_ticks.size() == 26);        // 50 mm at 2 mm a tick, and the one that saw it
  int told = 0;
  LogEvent event;
  while (loop.log().pop(event)) told += event.kind == LogEvent::Kind::ToolLetsGo && event.isWarning();
  CHECK(told == 1);
}

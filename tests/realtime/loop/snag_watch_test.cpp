#include "realtime/loop/snag_watch.h"

#include <catch2/catch.hpp>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"

using namespace palpate;

namespace {

/// 100 x 60 x 40 mm in the corners of its skin, each of which moves with a node.
Model boxed(double rate_hz = 500) {
  Model model = test::smallModel(rate_hz);
  model.skin.surface.vertices = {Vec3(0, 0, 0), Vec3(0.1, 0.06, 0.04)};
  model.skin.begin = {0, 1, 2};
  model.skin.node = {0, 1};
  model.skin.N = {1, 1};
  model.tools.first().shape = ToolShape::of(ToolKind::Sphere, 0.005);
  model.tools.first().start.pose.position = Vec3(0.05, 0.03, 0.042);
  return model;
}

/// The skin pushes the tool up by `below` and down by `above`, N.
void hold(ContactState& contact, double below, double above) {
  contact.vertex = {0, 1};
  contact.force = {Float4{0, 0, static_cast<float>(-below), 0}, Float4{0, 0, static_cast<float>(above), 0}};
  contact.count = 2;
}

}  // namespace

TEST_CASE("A tool that stands between skin before it and behind, far from its hand, is stuck", "[snag_watch]") {
  const Model model = boxed();
  SnagWatch watch(model);
  State state = test::FakePhysics(model).state();
  Vec3 hand(0.05, 0.03, -1);
  const auto ticksUntil = [&](double below, double above, double speed) {  // m/s
    hold(state.contact[0], below, above);
    state.tool[0].pose.position = Vec3(0.05, 0.03, 0.02);
    for (int t = 1; t <= 5000; ++t) {
      state.tool[0].pose.position.z() -= speed / model.scene.dynamics.rate_hz;
      if (watch.update(state, hand)) return t;
    }
    watch.recall({});
    return -1;
  };
  const int stuck = static_cast<int>(SnagWatch::seconds * model.scene.dynamics.rate_hz);
  CHECK(ticksUntil(5, 2, 0) == stuck);
  CHECK(ticksUntil(5, 2, 0) == stuck);  // and anew
  CHECK(ticksUntil(5, 8, 0) == stuck);  // held by what is behind it
  CHECK(ticksUntil(5, 1, 0) == -1);     // it presses, or lifts: however long
  CHECK(ticksUntil(0, 0, 0) == -1);     // it touches nothing
  CHECK(ticksUntil(5, 2, 2e-3) == -1);  // it gets on, if slowly
  hand.z() = -0.01;
  CHECK(ticksUntil(5, 2, 0) == -1);  // the hand is near
}

TEST_CASE("Of several tools each is looked at by itself, and what jaws hold they hold on purpose", "[snag_watch]") {
  Model model = boxed();
  model.tools.tool = {model.tools.first(), model.tools.first()};
  model.tools.body.push_back(model.tools.body[0]);
  model.tools.body[1].tool = 1;
  State state = test::FakePhysics(model).state();
  state.tool.resize(2);
  state.contact.push_back(state.contact[0]);
  state.contact[0].count = 0;
  hold(state.contact[1], 1, 1);
  const auto isStuck = [&](SnagWatch watch) {
    int found = 0;
    for (int t = 0; t < SnagWatch::seconds * model.scene.dynamics.rate_hz; ++t)
      found += watch.update(state, Vec3(0, 0, -1));
    return found == 1;
  };
  CHECK_FALSE(isStuck(SnagWatch(model, 0)));
  CHECK(isStuck(SnagWatch(model, 1)));
  model.tools.tool[1].jaws = true;
  CHECK_FALSE(isStuck(SnagWatch(model, 1)));
}

TEST_CASE("A tool that is stuck lets go, is told of, goes to its hand, and touches again once it is clear there",
          "[snag_watch]") {
  const Model model = boxed(100);
  test::FakePhysics physics(model);
  const Vec3 away(0.05, 0.03, 1);
  Vec3 at(0.05, 0.03, 0.02);
  int free_ticks = 0, doubted = 0;
  physics.on_tick = [&](State& state, StepReport& report) {
    const Command& command = physics.last_command;
    if (command.lets_go[0]) {
      CHECK(command.tools[0].pose.position == away);
      report.flags |= kLetsGo;
      report.loads[0].near_count = ++free_ticks < 40;
      if (free_ticks == 20) at = away;
      doubted += doubtOf(model, report) == Doubt::Contact;
      state.contact[0].count = 0;
    } else if (free_ticks == 0) {
      hold(state.contact[0], 1, 1);
    }
    state.tool[0].pose.position = at;
    state.u[0].x = 0.05F;
  };
  SimulationLoopOptions options;
  options.tick_limit = 700;
  SimulationLoop loop(model, physics, nullptr, options);
  Pose hand;
  hand.position = away;
  loop.commands().push(Request::moveTool(hand));
  test::FakeClock clock;
  loop.run(clock);
  CHECK(loop.summary().let_go_count == 1);
  CHECK(loop.summary().restored_count == 0);
  CHECK(physics.state().u[0].x == 0.05F);  // the tissue is left to itself
  CHECK(free_ticks >= 40);
  CHECK(free_ticks <= 46);  // it looks every 50 ms
  CHECK(doubted == free_ticks);
  int told = 0;
  LogEvent event;
  while (loop.log().pop(event)) told += event.kind == LogEvent::Kind::ToolLetsGo && event.isWarning();
  CHECK(told == 1);
}

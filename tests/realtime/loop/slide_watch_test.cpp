#include "realtime/loop/slide_watch.h"

#include <catch2/catch.hpp>

#include "realtime/fakes.h"
#include "realtime/loop/simulation_loop.h"
#include "setup/free_axes.h"

using namespace palpate;

namespace {

/// Stands on ice that is free along x and y.
Model onIce() {
  Model model = test::smallModel(500);
  model.imposed = {4, 0, 4, 0};
  return model;
}

/// The ticks after which `watch` finds a slide with all nodes at `u`; -1: none.
int ticksUntilFound(SlideWatch& watch, const Model& model, const Float4& u, const StepReport& report = {},
                    bool pulled = false) {
  State state = test::FakePhysics(model).state();
  for (Float4& of_node : state.u) of_node = u;
  for (int t = 1; t <= 2000; ++t)
    if (watch.update(state, report, pulled)) return t;
  return -1;
}

}  // namespace

TEST_CASE("Axes along which nothing is held are free", "[slide_watch]") {
  Model model = onIce();
  CHECK(freeAxes(model) == Vec3(1, 1, 0));
  model.imposed[1] = 2;
  CHECK(freeAxes(model) == Vec3(1, 0, 0));
  model.imposed[1] = 7;
  CHECK(freeAxes(model) == Vec3(0, 0, 0));
  model.imposed.clear();  // nothing is known
  CHECK(freeAxes(model) == Vec3(0, 0, 0));
  model.scene.rigid.emplace_back();
  CHECK(freeAxes(model) == Vec3(1, 1, 1));
  SlideWatch watch(model);  // what slides off a table has slid off
  CHECK(ticksUntilFound(watch, model, {10, 0, 0, 0}) == -1);
}

TEST_CASE("A body that is further from its place than it is large has slid away", "[slide_watch]") {
  const Model model = onIce();
  const auto size = static_cast<float>(Vec3(0.01, 0.02, 0.03).norm());
  SlideWatch watch(model);
  CHECK(ticksUntilFound(watch, model, {1.01F * size, 0, 0, 0}) == 250);
  CHECK(ticksUntilFound(watch, model, {0.8F * size, -0.8F * size, 0, 0}) == 250);
  CHECK(ticksUntilFound(watch, model, {0.99F * size, 0, 0, 0}) == -1);
  CHECK(ticksUntilFound(watch, model, {0, 0, 2 * size, 0}) == -1);  // held along z: that is a fold's matter
  // While something holds it, it is where that wants it.
  StepReport touched;
  touched.contact_count = 1;
  CHECK(ticksUntilFound(watch, model, {2 * size, 0, 0, 0}, touched) == -1);
  StepReport gripped;
  gripped.loads[1].contact_count = 1;
  CHECK(ticksUntilFound(watch, model, {2 * size, 0, 0, 0}, gripped) == -1);
  CHECK(ticksUntilFound(watch, model, {2 * size, 0, 0, 0}, {}, true) == -1);
  SlideWatch held(test::smallModel(500));
  CHECK(ticksUntilFound(held, model, {2 * size, 0, 0, 0}) == -1);
}

TEST_CASE("A body that lies turned over beneath what it stood on has left its place", "[slide_watch]") {
  const Model model = onIce();
  const auto found = [&model](const Mat3& F) {
    State state = test::FakePhysics(model).state();
    for (std::size_t i = 0; i < model.X.size(); ++i) {
      const Vec3 u = F * model.X[i] - model.X[i];
      state.u[i] = {static_cast<float>(u.x()), static_cast<float>(u.y()), static_cast<float>(u.z()), 0};
    }
    SlideWatch watch(model);
    for (int t = 1; t <= 600; ++t)
      if (watch.update(state, {}, false)) return true;
    return false;
  };
  const auto turned = [](double degrees) {
    return Eigen::AngleAxisd(degrees * EIGEN_PI / 180, Vec3::UnitY()).toRotationMatrix();
  };
  CHECK(found(turned(180)));
  CHECK(found(turned(100)));
  CHECK_FALSE(found(turned(80)));
  CHECK_FALSE(found(turned(0)));
  CHECK_FALSE(found(Vec3(1.6, 0.7, 0.3).asDiagonal()));  // pressed flat: that is no turn
  CHECK(found(turned(180) * Vec3(1.6, 0.7, 0.3).asDiagonal()));
}

TEST_CASE("A body that has slid away is put back to its place, counted and told of", "[slide_watch]") {
  const Model model = onIce();
  test::FakePhysics physics(model);
  physics.on_tick = [](State& state, StepReport&) {
    for (Float4& u : state.u) u = {state.tick < 100 ? 0 : 0.05F, 0, 0, 0};
  };
  SimulationLoopOptions options;
  options.tick_limit = 300;
  SimulationLoop loop(model, physics, nullptr, options);
  test::FakeClock clock;
  loop.run(clock);
  CHECK(loop.summary().restored_count == 1);
  CHECK_FALSE(loop.summary().frozen);
  int told = 0;
  LogEvent event;
  while (loop.log().pop(event)) told += event.kind == LogEvent::Kind::RestoredSlid && event.isRestore();
  CHECK(told == 1);
  CHECK(physics.state().u[0].x == 0);
}

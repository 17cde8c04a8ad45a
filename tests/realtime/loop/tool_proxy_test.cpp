#include "realtime/loop/tool_proxy.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "realtime/fakes.h"
#include "step/trust.h"

using namespace palpate;

namespace {

Model toolModel() {
  Model model = test::smallModel(500);
  model.scene.tools[0].shape.radius = 0.01;
  model.tools.first().max_force = 4;
  return model;
}

/// The tool at the origin, pushed up by the tissue.
struct Touch {
  State state;
  StepReport report;
  Touch() {
    report.tool_force = Vec3(0, 0, 1);
    state.u.resize(4);
  }
};

Pose handAt(double x, double y, double z) {
  Pose pose;
  pose.position = Vec3(x, y, z);
  return pose;
}

/// The tool's target under this hand.
Pose follow(ToolProxy& proxy, const Pose& hand, const State& state, StepReport last) {
  last.loads[0].force = last.tool_force;
  return proxy.follow(ToolPosture{hand}, state, last).pose;
}

}  // namespace

TEST_CASE("Where nothing is doubted the tool is the hand, bit for bit", "[tool_proxy]") {
  const Model model = toolModel();
  ToolProxy proxy(model);
  Touch touch;
  touch.report.min_J = TrustLimits::min_J + 1e-6F;
  touch.report.max_penetration = TrustLimits::penetration * model.scene.tools[0].shape.radius;
  touch.report.tool_force = Vec3(0, 0, 0.5 * model.tools.first().max_force);
  Pose hand = handAt(0.1, -0.2, -0.3);
  hand.orientation = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
  const Pose tool = follow(proxy, hand, touch.state, touch.report);
  CHECK(tool.position == hand.position);
  CHECK(tool.orientation.coeffs() == hand.orientation.coeffs());
  CHECK(proxy.yieldAfter({}, {}, {}) == 0);
}

TEST_CASE("Where the skin is drawn out, a tool draws it no further - back and aside it is free", "[tool_proxy]") {
  Model model = toolModel();
  model.skin.begin = {0, 1, 2};  // each vertex moves with a node of its own
  model.skin.node = {0, 1};
  model.skin.N = {1, 1};
  ToolProxy proxy(model);
  Touch touch;
  State& state = touch.state;
  state.u.assign(2, Float4{});
  state.u[0].z = -0.05F;  // what the tool touches
  ContactState& contact = state.contact[0];
  contact.count = 1;
  contact.vertex = {0};
  contact.force = {Float4{0, 0, -1, 0}};
  contact.normal = {Vec3f::UnitZ()};
  constexpr double step = 1e-3;
  const auto moved = [&](double x, double z) {
    return Vec3(follow(proxy, handAt(x, 0, z), state, touch.report).position);
  };
  contact.samples.largest_stretch = YieldLimits::free_stretch;
  CHECK(moved(0, -step) == Vec3(0, 0, -step));
  contact.samples.largest_stretch = 0.5 * (YieldLimits::free_stretch + YieldLimits::stretch);
  CHECK(moved(0, -step).z() == Approx(-0.25 * step));
  CHECK(moved(0, -1).z() == Approx(-0.25 / model.scene.dynamics.rate_hz));  // of what it may go in a tick at 1 m/s
  contact.samples.largest_stretch = 2 * YieldLimits::stretch;
  CHECK(moved(0, -step).norm() < 1e-12);
  CHECK(proxy.yieldAfter(handAt(0, 0, -step), state, touch.report) == Approx(step));
  CHECK((moved(step, -step) - Vec3(step, 0, 0)).norm() < 1e-12);
  CHECK((moved(0, step) - Vec3(0, 0, step)).norm() < 1e-12);
  state.u[1].z = -0.1F;  // the body as a whole has gone further: forward is back
  CHECK((moved(0, -step) - Vec3(0, 0, -step)).norm() < 1e-12);

  Model other = model;  // other nodes: what the vertex's row says of the state is another displacement
  other.skin.node = {1, 0};
  state.u[0].z = 0, state.u[1].z = -0.05F;
  proxy.goOnWith(other);
  CHECK(moved(0, -step).norm() < 1e-12);
}

TEST_CASE("Each limit slows the advance and stops it - the gravest counts", "[tool_proxy]") {
  const Model model = toolModel();
  const ToolProxy proxy(model);
  State state;
  StepReport report;
  CHECK(proxy.freedom(report) == 1);
  report.max_penetration =
      0.5 * (TrustLimits::penetration + YieldLimits::penetration) * model.scene.tools[0].shape.radius;
  CHECK(proxy.freedom(report) == Approx(0.5));
  report.min_J = static_cast<float>(0.25 * TrustLimits::min_J + 0.75 * YieldLimits::min_J);
  CHECK(proxy.freedom(report) == Approx(0.25));
  report.max_penetration = YieldLimits::penetration * model.scene.tools[0].shape.radius;
  CHECK(proxy.freedom(report) == 0);
  report = {};
  report.min_J = -0.1F;
  CHECK(proxy.freedom(report) == 0);
}

TEST_CASE("A tool that yields is slowed where it goes deeper, and free sideways and backwards", "[tool_proxy]") {
  const Model model = toolModel();
  ToolProxy proxy(model);
  Touch touch;
  const double radius = model.scene.tools[0].shape.radius;
  touch.report.max_penetration = 0.5 * (TrustLimits::penetration + YieldLimits::penetration) * radius;  // g^2 = 1/4
  // The hand a millimetre deeper and one aside: within the reach of 2 mm a tick.
  Pose tool = follow(proxy, handAt(1e-3, 0, -1e-3), touch.state, touch.report);
  CHECK(tool.position.x() == Approx(1e-3).epsilon(1e-12));
  CHECK(tool.position.z() == Approx(-0.25e-3).epsilon(1e-12));
  CHECK(proxy.yieldAfter({}, {}, {}) == Approx(0.75e-3).epsilon(1e-12));
  // Far away: no faster than the tool may go.
  tool = follow(proxy, handAt(0, 0, -0.05), touch.state, touch.report);
  CHECK(tool.position.z() == Approx(-0.25 * 2e-3).epsilon(1e-12));
  // Backwards and sideways: all the way.
  tool = follow(proxy, handAt(1e-3, 1e-3, 1e-3), touch.state, touch.report);
  CHECK(tool.position == Vec3(1e-3, 1e-3, 1e-3));
  CHECK(proxy.yieldAfter({}, {}, {}) == 0);
  // On a slope, too, it stays under the hand; and what the tissue beside it pushes back is no free way.
  touch.report.tool_force = Vec3(0.6, 0, 0.8);
  tool = follow(proxy, handAt(0, 0, -1e-3), touch.state, touch.report);
  CHECK(tool.position.isApprox(Vec3(0, 0, -0.25e-3), 1e-12));
  tool = follow(proxy, handAt(-1e-3, 1e-3, 0), touch.state, touch.report);
  CHECK(tool.position.isApprox(Vec3(-0.25e-3, 1e-3, 0), 1e-12));
  touch.report.tool_force = Vec3(0, 0, 1);
  // Beyond the limit it stands.
  touch.report.max_penetration = 10 * radius;
  tool = follow(proxy, handAt(0, 0, -0.05), touch.state, touch.report);
  CHECK(tool.position.norm() < 1e-15);
  CHECK(proxy.yieldAfter({}, {}, {}) == Approx(0.05));
  // It is not the tool's doing where it touches nothing.
  touch.report.tool_force.setZero();
  CHECK(follow(proxy, handAt(0, 0, -0.05), touch.state, touch.report).position == Vec3(0, 0, -0.05));
}

TEST_CASE("A tool at its max_force is said to yield", "[tool_proxy]") {
  const Model model = toolModel();
  ToolProxy proxy(model);
  Touch touch;
  const Pose hand = handAt(0, 0, -0.05);
  touch.report.tool_force = Vec3(0, 0, 0.9 * model.tools.first().max_force);
  CHECK(follow(proxy, hand, touch.state, touch.report).position == hand.position);  // it gives way within the step
  CHECK(proxy.yieldAfter(hand, touch.state, touch.report) == 0);
  touch.report.tool_force = Vec3(0, 0, model.tools.first().max_force);
  CHECK(proxy.yieldAfter(hand, touch.state, touch.report) == Approx(0.05));
}

TEST_CASE("In tissue no tool advances faster than half of sound", "[tool_proxy]") {
  Model model = toolModel();
  double sound = 1e9;
  for (const Material& m : model.materials) sound = std::min(sound, std::sqrt(m.waveModulus() / m.density));
  model.tools.first().max_speed = 10 * sound;
  ToolProxy proxy(model);
  Touch touch;
  const double tick_s = 1 / model.scene.dynamics.rate_hz, most = 0.5 * sound * tick_s;
  CHECK(follow(proxy, handAt(1e-4, 0, -0.9 * most), touch.state, touch.report).position == Vec3(1e-4, 0, -0.9 * most));
  CHECK(proxy.yieldAfter({}, {}, {}) == 0);
  const Pose tool = follow(proxy, handAt(1e-4, 0, -5 * most), touch.state, touch.report);
  CHECK(tool.position.isApprox(Vec3(1e-4, 0, -most), 1e-12));
  CHECK(proxy.yieldAfter({}, {}, {}) == Approx(4 * most).epsilon(1e-12));
  touch.report.tool_force.setZero();  // in the air it may
  CHECK(follow(proxy, handAt(0, 0, -5 * most), touch.state, touch.report).position == Vec3(0, 0, -5 * most));
}

TEST_CASE("After the tissue was put back the tool comes gently, until it has reached the hand", "[tool_proxy]") {
  const Model model = toolModel();
  ToolProxy proxy(model);
  Touch touch;
  proxy.beGentle();
  const Pose hand = handAt(0, 0, -0.01);
  double fastest = 0;
  int ticks = 0;
  while (touch.state.tool[0].pose.position.z() > hand.position.z() && ticks < 1000) {
    const Pose tool = follow(proxy, hand, touch.state, touch.report);
    fastest = std::max(fastest, (tool.position - touch.state.tool[0].pose.position).norm());
    touch.state.tool[0].pose = tool;
    ++ticks;
  }
  CHECK(fastest * 500 == Approx(ToolProxy::gentle_speed));
  CHECK(std::abs(ticks - 250) <= 1);  // 10 mm at 20 mm/s
  touch.state.tool[0].pose = hand;
  // Then, after a while there, as fast as the hand.
  for (int k = 0; k < 500 * ToolProxy::arrival_seconds; ++k) follow(proxy, hand, touch.state, touch.report);
  CHECK(follow(proxy, handAt(0, 0, -0.5), touch.state, touch.report).position == Vec3(0, 0, -0.5));

  // In the air it comes faster.
  ToolProxy free(model);
  State state;
  state.u.resize(4);
  free.beGentle();
  const Pose tool = follow(free, handAt(0, 0, -1), state, {});
  CHECK(tool.position.z() * 500 == Approx(-ToolProxy::approach_speed));
  for (int k = 0; k < 500 * ToolProxy::arrival_seconds; ++k)
    CHECK(follow(free, handAt(0, 0, 0), state, {}).position == Vec3::Zero());
  CHECK(follow(free, handAt(0, 0, -1), state, {}).position == Vec3(0, 0, -1));
}

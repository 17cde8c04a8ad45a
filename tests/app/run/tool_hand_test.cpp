#include "app/run/tool_hand.h"

#include "app/run/attract_loop.h"
#include "app/run/grasp.h"

#include <catch2/catch.hpp>

#include <numbers>
#include <vector>

#include "discretization/surface/solids.h"

using namespace palpate;
using namespace palpate::app;

namespace {

/// A ball of 50 mm about (0, 0, 0.05), the tool above it, pointing down.
Model organ() {
  Model model;
  model.skin.surface = ellipsoidSurface({0.05, 0.05, 0.05}, 0.004);
  for (Vec3& X : model.skin.surface.vertices) X.z() += 0.05;
  model.tools.first().start.pose.position = {0, 0, 0.15};
  model.scene.tools[0].shape.radius = 0.01;
  return model;
}

Camera inFront() {
  Camera camera;
  camera.target = {0, 0, 0.05};
  camera.distance = 0.6;
  camera.azimuth_deg = -90;  // looks along +y, x to the right
  camera.elevation_deg = 20;
  return camera;
}

constexpr int height = 800;
constexpr double speed = 0.02;  // m/s, of keys

std::vector<Request> ask(ToolHand& hand, const Motion& motion, double seconds = 0.016,
                         const std::optional<Vec3>& touched = {}) {
  return hand.apply(motion, touched, inFront(), height, speed, seconds, hand.target());
}

Vec3 velocityOf(const Request& request) { return request.pose.position; }

const Vec3 on_the_side = Vec3(0.05, 0, 0.05);

}  // namespace

TEST_CASE("Dragged in the view's plane, the tip stays under the pointer, and gets there with the next picture",
          "[tool_hand]") {
  const Model model = organ();
  const Camera camera = inFront();
  ToolHand hand(model);
  hand.setMode(HandMode::Free);
  const Vec3 before = camera.project(hand.target().position, 1280, height);
  Motion motion;
  motion.move_tool = {40, -25};
  const std::vector<Request> requests = ask(hand, motion, 0.5);
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].kind == Request::Kind::MoveTool);
  CHECK(requests[0].pose.position == hand.target().position);
  CHECK(requests[0].value == 0.5);
  const Vec3 after = camera.project(hand.target().position, 1280, height);
  CHECK(after.x() - before.x() == Approx(40).margin(0.5));
  CHECK(after.y() - before.y() == Approx(-25).margin(0.5));
  CHECK(after.z() == Approx(before.z()).epsilon(1e-9));  // neither nearer nor further
}

TEST_CASE("Held keys are a velocity, the same however seldom a picture comes - let go, it is none", "[tool_hand]") {
  const Model model = organ();
  for (const double seconds : {0.016, 0.5}) {
    ToolHand hand(model);
    Motion keys;
    keys.tool_keys = {1, 0, 0};
    std::vector<Request> requests = ask(hand, keys, seconds);
    REQUIRE(requests.size() == 1);
    CHECK(requests[0].kind == Request::Kind::Steer);
    CHECK((velocityOf(requests[0]) - Vec3(speed, 0, 0)).norm() < 1e-12);
    CHECK(requests[0].value > seconds);  // holds until the next picture, and not for ever
    CHECK(requests[0].value <= 2);
    keys.tool_keys = {0, 1, -1};  // away from the viewer, and into the tissue
    requests = ask(hand, keys, seconds);
    CHECK((velocityOf(requests[0]) - Vec3(0, speed, -speed)).norm() < 1e-12);
    requests = ask(hand, Motion{}, seconds);
    REQUIRE(requests.size() == 1);
    CHECK(velocityOf(requests[0]).isZero(0));
    CHECK(ask(hand, Motion{}, seconds).empty());
  }
}

TEST_CASE("A tapped key moves the tool by the same way however soon the next picture comes", "[tool_hand]") {
  const Model model = organ();
  for (const double seconds : {0.004, 0.5}) {
    ToolHand hand(model);
    Motion tap;
    tap.tool_keys = {0, 0, 1};
    tap.tapped = true;
    const std::vector<Request> requests = ask(hand, tap, seconds);
    REQUIRE(requests.size() == 1);
    CHECK(velocityOf(requests[0]).norm() * requests[0].value == Approx(0.08 * speed));
    CHECK(ask(hand, Motion{}, seconds).empty());  // nothing cuts it short
  }
}

TEST_CASE("The tool does not get lost, and rests when nothing is asked", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  CHECK(ask(hand, Motion{}).empty());
  hand.setMode(HandMode::Free);
  Motion far;
  far.move_tool = {500, 0};
  for (int k = 0; k < 100; ++k) ask(hand, far);
  CHECK(hand.target().position.norm() < 1.0);
  CHECK(hand.target().position.x() > 0.06);  // and yet reaches beyond the organ
  Motion keys;
  keys.tool_keys = {1, 0, 0};
  CHECK(velocityOf(ask(hand, keys)[0]).dot(hand.target().position - Vec3(0, 0, 0.075)) < 1e-9);
  const std::vector<Request> back = hand.toStart();
  CHECK(back.back().pose.position == model.tools.first().start.pose.position);
}

TEST_CASE("A click on the skin brings the probe there, upright, from above, and around the organ", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  const std::vector<Request> requests = ask(hand, {}, 0.016, on_the_side);
  REQUIRE(requests.size() >= 3);
  CHECK(hand.onSkin());
  CHECK((hand.target().position - on_the_side).norm() < 1e-3);
  CHECK((hand.target().orientation * Vec3::UnitZ() - Vec3::UnitX()).norm() < 0.1);
  for (const Request& way : requests) CHECK((way.pose.position - Vec3(0, 0, 0.05)).norm() > 0.049);
  for (std::size_t k = 1; k < requests.size(); ++k) {  // no way leads through the organ
    const Vec3 a = requests[k - 1].pose.position, b = requests[k].pose.position;
    for (const double s : {0.25, 0.5, 0.75}) CHECK((a + s * (b - a) - Vec3(0, 0, 0.05)).norm() > 0.049);
  }
  CHECK(requests.back().pose.position == hand.target().position);
}

TEST_CASE("On the skin the wheel presses along its normal, and a drag glides at that depth", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  ask(hand, {}, 0.016, on_the_side);
  Motion wheel;
  wheel.push_tool_notches = 8;
  const std::vector<Request> pressed = ask(hand, wheel);
  REQUIRE(pressed.size() == 1);
  CHECK(hand.depth() == Approx(0.004));
  CHECK((hand.target().position - Vec3(0.046, 0, 0.05)).norm() < 1e-3);
  const double angle = 0.15;
  const Vec3 next = Vec3(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.05);
  const std::vector<Request> glided = ask(hand, {}, 0.1, next);
  REQUIRE(glided.size() == 1);
  CHECK((hand.target().position - (0.046 / 0.05 * (next - Vec3(0, 0, 0.05)) + Vec3(0, 0, 0.05))).norm() < 1e-3);
  CHECK(glided[0].value >= 0.1);
  CHECK(hand.depth() == Approx(0.004));
}

TEST_CASE("Over the skin keys go along it, hold the depth and turn the probe with it", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  ask(hand, {}, 0.016, Vec3(0, 0, 0.1));
  Motion keys;
  keys.tool_keys = {1, 0, 0};
  Pose goal = hand.target();
  for (int k = 0; k < 200;
       ++k) {  // 20 mm over the top at 10 pictures a second, each tenth carried out as the loop does
    const auto requests = hand.apply(keys, {}, inFront(), height, speed, 0.05, goal);
    REQUIRE(requests.size() == 1);
    goal.position += 0.005 * velocityOf(requests[0]);
    const double w = requests[0].point.norm();
    if (w > 0)
      goal.orientation = (Quat(Eigen::AngleAxisd(0.005 * w, requests[0].point / w)) * goal.orientation).normalized();
  }
  const Vec3 out = goal.position - Vec3(0, 0, 0.05);
  CHECK(out.norm() == Approx(0.05).margin(5e-4));
  CHECK(std::atan2(out.x(), out.z()) == Approx(0.4).epsilon(0.05));
  CHECK((goal.orientation * Vec3::UnitZ() - out.normalized()).norm() < 0.15);
}

TEST_CASE("The probe can be tilted, and stands upright again when asked", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  ask(hand, {}, 0.016, Vec3(0, 0, 0.1));
  const Quat before = hand.target().orientation;
  Motion turn;
  turn.turn_tool = {50, 0};
  ask(hand, turn);
  CHECK(hand.target().orientation.angularDistance(before) == Approx(0.3).epsilon(0.01));
  hand.upright();
  CHECK(hand.target().orientation.angularDistance(before) < 1e-9);
}

TEST_CASE("Press goes into the skin below the probe and Lift off it, from where it began and from a place",
          "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  std::vector<Request> requests = hand.press(0.004, speed, hand.target());
  REQUIRE(requests.size() == 2);  // down to the skin, then in
  CHECK(hand.onSkin());
  CHECK((requests[0].pose.position - Vec3(0, 0, 0.1)).norm() < 1e-3);
  CHECK((requests[1].pose.position - Vec3(0, 0, 0.096)).norm() < 1e-3);
  CHECK(requests[1].kind == Request::Kind::ThenMoveTool);
  CHECK(requests[1].value == Approx(0.004 / speed).epsilon(0.01));
  requests = hand.lift(speed, hand.target());
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].kind == Request::Kind::MoveTool);
  CHECK((hand.target().position - Vec3(0, 0, 0.105)).norm() < 1e-3);
  ask(hand, {}, 0.016, Vec3(0.002, 0, 0.1));  // a click brings it down again
  CHECK(hand.depth() == 0);
  hand.lift(speed, hand.target());
  // What is under way is not cut short: the way to a place goes around the organ.
  ask(hand, {}, 0.016, on_the_side);
  requests = hand.press(0.004, speed, model.tools.first().start.pose);
  REQUIRE(requests.size() == 1);
  CHECK(requests[0].kind == Request::Kind::ThenMoveTool);
  CHECK((hand.target().position - Vec3(0.046, 0, 0.05)).norm() < 1e-3);
}

TEST_CASE("A free probe presses as it is turned", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  hand.setMode(HandMode::Free);
  const Quat before = hand.target().orientation;
  hand.press(0.003, speed, hand.target());
  CHECK_FALSE(hand.onSkin());
  CHECK((hand.target().position - Vec3(0, 0, 0.097)).norm() < 1e-3);
  CHECK(hand.target().orientation.angularDistance(before) == 0);
}

TEST_CASE("The demo that plays by itself presses at several places, goes home and rests", "[tool_hand]") {
  const Model model = organ();
  const std::vector<Vec3> places = facingPlaces(model, 4);
  REQUIRE(places.size() == 4);
  CHECK((places[0] - Vec3(0, 0, 0.1)).norm() < 0.01);
  for (std::size_t k = 1; k < places.size(); ++k) CHECK((places[k] - places[0]).norm() > 0.01);
  AttractLoop loop(model);
  ToolHand hand(model);
  std::vector<Vec3> pressed;
  double moved = 0, rested = 0;
  constexpr double period = AttractLoop::show_seconds + AttractLoop::rest_seconds;
  for (double t = 0; t < 2 * period; t += 0.2) {
    const bool was_pressing = hand.onSkin() && hand.depth() > 0;
    if (!loop.next(t, hand, hand.target()).empty()) moved = t;
    if (!was_pressing && hand.onSkin() && hand.depth() > 0) pressed.push_back(hand.target().position);
    rested += loop.rests() ? 0.2 : 0;
    if (loop.rests()) CHECK(hand.target().position == model.tools.first().start.pose.position);
  }
  CHECK(pressed.size() == 8);
  CHECK(moved < 2 * period - 20);
  CHECK(rested > 0.4 * 2 * period);
}

TEST_CASE("Grasp and lift closes the jaws until they hold, and then goes up", "[tool_hand]") {
  Model model = organ();
  model.scene.tools[0].opening = 0.012;
  ToolHand hand(model);
  Grasp grasp;
  Snapshot now;
  double& opening = now.tools.tool[0].opening;
  opening = 0.012;
  constexpr double held = 0.007;  // m, where what is between them lets them close no further
  const Vec3 before = hand.target().position;
  double asked = 0.012;
  int pictures = 0;
  for (; !grasp.done() && pictures < 100; ++pictures) {
    now.force.time_s = 0.1 * pictures;  // ten pictures a second
    for (const Request& request : grasp.next(now, hand)) {
      if (request.kind != Request::Kind::SetOpening) continue;
      CHECK(request.value >= asked - 0.1 * jaw_speed - 1e-12);  // no faster than that
      asked = request.value;
      opening = std::max(held, request.value);
    }
  }
  CHECK(grasp.done());
  CHECK(asked < held);  // it squeezes on
  CHECK(now.force.time_s > (0.012 - held) / jaw_speed);
  CHECK(now.force.time_s < (0.012 - held) / jaw_speed + 2 * Grasp::still_seconds);
  CHECK((hand.target().position - before - Vec3(0, 0, Grasp::lift)).norm() < 1e-12);
  CHECK(grasp.next(now, hand).empty());
}

#include "app/run/tool_hand.h"

#include <catch2/catch.hpp>

#include <limits>

using namespace palpate;
using namespace palpate::app;

namespace {

/// An organ between (-0.1, -0.1, 0) and (0.1, 0.1, 0.1), the tool above it, pointing down.
Model organ() {
  Model model;
  model.skin.surface.vertices = {{-0.1, -0.1, 0}, {0.1, 0.1, 0.1}};
  model.tool_start.position = {0, 0, 0.15};
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

}  // namespace

TEST_CASE("Dragged in the view's plane, the tip stays under the pointer", "[tool_hand]") {
  const Model model = organ();
  const Camera camera = inFront();
  ToolHand hand(model);
  const Vec3 before = camera.project(hand.target().position, 1280, height);
  Actions actions;
  actions.move_tool = {40, -25};
  REQUIRE(hand.apply(actions, camera, height, 0.02, 0.016));
  const Vec3 after = camera.project(hand.target().position, 1280, height);
  CHECK(after.x() - before.x() == Approx(40).margin(0.5));
  CHECK(after.y() - before.y() == Approx(-25).margin(0.5));
  CHECK(after.z() == Approx(before.z()).epsilon(1e-9));  // neither nearer nor further
}

TEST_CASE("Wheel and keys move along the tool's axis and across it", "[tool_hand]") {
  const Model model = organ();
  const Camera camera = inFront();
  ToolHand hand(model);
  Actions wheel;
  wheel.push_tool_notches = 4;
  REQUIRE(hand.apply(wheel, camera, height, 0.02, 0.016));
  CHECK((hand.target().position - Vec3(0, 0, 0.148)).norm() < 1e-12);  // 4 notches of 0.5 mm

  hand.toStart();
  Actions keys;
  keys.tool_keys = {1, 0, 0};
  REQUIRE(hand.apply(keys, camera, height, 0.02, 0.5));
  CHECK((hand.target().position - Vec3(0.01, 0, 0.15)).norm() < 1e-12);
  keys.tool_keys = {0, 1, -1};  // away from the viewer, and into the tissue
  hand.toStart();
  REQUIRE(hand.apply(keys, camera, height, 0.02, 0.5));
  CHECK((hand.target().position - Vec3(0, 0.01, 0.14)).norm() < 1e-12);
}

TEST_CASE("The tool neither turns nor gets lost, and rests when nothing is asked", "[tool_hand]") {
  const Model model = organ();
  ToolHand hand(model);
  CHECK_FALSE(hand.apply(Actions{}, inFront(), height, 0.02, 0.016));
  Actions far;
  far.tool_keys = {1, 0, 0};
  for (int k = 0; k < 100; ++k) hand.apply(far, inFront(), height, 1.0, 1.0);
  CHECK(hand.target().position.norm() < 1.0);
  CHECK(hand.target().position.x() > 0.1);  // and yet reaches beyond the organ
  CHECK(hand.target().orientation.coeffs() == model.tool_start.orientation.coeffs());
  hand.toStart();
  CHECK(hand.target().position == model.tool_start.position);
}

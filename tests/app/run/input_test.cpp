#include "app/run/input.h"

#include <GLFW/glfw3.h>

#include <catch2/catch.hpp>

using namespace palpate;
using namespace palpate::app;

namespace {

Input moved(double x, double y) {
  Input input;
  input.mouse_delta = {x, y};
  return input;
}

}  // namespace

TEST_CASE("Each drag does its own thing and nothing else", "[input]") {
  struct Case {
    bool left, right, shift, ctrl;
    Drag drag;
  };
  const Case cases[] = {{true, false, false, false, Drag::Orbit},
                        {false, true, false, false, Drag::Pan},
                        {true, false, true, false, Drag::MoveTool},
                        {false, true, true, false, Drag::PushTool},
                        {true, false, false, true, Drag::Pull}};
  for (const Case& c : cases) {
    Controls controls;
    Input input = moved(3, 5);
    input.left = c.left;
    input.right = c.right;
    input.shift = c.shift;
    input.ctrl = c.ctrl;
    Actions first = controls.read(input, false);
    CHECK(controls.drag() == c.drag);
    CHECK(first.orbit.isZero());  // the press is no movement
    CHECK(first.pan.isZero());
    CHECK(first.move_tool.isZero());
    CHECK(first.push_tool_px == 0);
    CHECK(first.pull_begin == (c.drag == Drag::Pull));

    const Actions next = controls.read(input, false);
    CHECK(next.orbit == (c.drag == Drag::Orbit ? Eigen::Vector2d(3, 5) : Eigen::Vector2d(0, 0)));
    CHECK(next.pan == (c.drag == Drag::Pan ? Eigen::Vector2d(3, 5) : Eigen::Vector2d(0, 0)));
    CHECK(next.move_tool == (c.drag == Drag::MoveTool ? Eigen::Vector2d(3, 5) : Eigen::Vector2d(0, 0)));
    CHECK(next.push_tool_px == (c.drag == Drag::PushTool ? 5 : 0));
    CHECK(next.pulling == (c.drag == Drag::Pull));
    CHECK_FALSE(next.pull_begin);
  }
}

TEST_CASE("A drag keeps its meaning until the button comes up", "[input]") {
  Controls controls;
  Input input = moved(1, 0);
  input.left = true;
  input.shift = true;
  controls.read(input, false);
  input.shift = false;       // let go early
  input.mouse_taken = true;  // and wander over a panel
  const Actions actions = controls.read(input, false);
  CHECK(controls.drag() == Drag::MoveTool);
  CHECK(actions.move_tool == Eigen::Vector2d(1, 0));
  input.left = false;  // and up after a last stretch, which a slow picture shows together with it
  CHECK(controls.read(input, false).move_tool == Eigen::Vector2d(1, 0));
  CHECK(controls.drag() == Drag::None);
  CHECK(controls.read(input, false).move_tool.isZero());
}

TEST_CASE("What belongs to a panel does not reach the view", "[input]") {
  Controls controls;
  Input input = moved(4, 4);
  input.left = true;
  input.mouse_taken = true;
  input.wheel = 1;
  controls.read(input, false);
  input.mouse_taken = false;  // dragged off the panel, e.g. a slider's end
  input.wheel = 0;
  Actions actions = controls.read(input, false);
  CHECK(controls.drag() == Drag::Panel);
  CHECK(actions.orbit.isZero());

  Controls others;
  Input wheel;
  wheel.wheel = 1;
  wheel.mouse_taken = true;
  CHECK(others.read(wheel, false).zoom == 0);
  wheel.mouse_taken = false;
  CHECK(others.read(wheel, false).zoom == 1);

  Input typing;
  typing.keys_taken = true;
  typing.press(Key::Backspace);
  typing.press(Key::Escape);
  actions = others.read(typing, false);
  CHECK_FALSE(actions.reset);
  CHECK_FALSE(actions.quit);
}

TEST_CASE("Keys have meanings by their GLFW codes, others have none", "[input]") {
  CHECK(keyFromGlfw(GLFW_KEY_SPACE) == Key::Space);
  CHECK(keyFromGlfw(GLFW_KEY_PERIOD) == Key::Period);
  CHECK(keyFromGlfw(GLFW_KEY_P) == Key::P);
  CHECK_FALSE(keyFromGlfw(GLFW_KEY_Q));
  CHECK_FALSE(keyFromGlfw(GLFW_KEY_UNKNOWN));
}

TEST_CASE("Shift turns the wheel from zooming to pushing the tool", "[input]") {
  Controls controls;
  Input input;
  input.wheel = -2;
  input.shift = true;
  const Actions actions = controls.read(input, false);
  CHECK(actions.zoom == 0);
  CHECK(actions.push_tool_notches == -2);
}

TEST_CASE("Each key has its action; Escape closes the help before it quits", "[input]") {
  Controls controls;
  const auto with = [&](Key key, bool help = false) {
    Input input;
    input.press(key);
    return controls.read(input, help);
  };
  CHECK(with(Key::Space).toggle_pause);
  CHECK(with(Key::Backspace).reset);
  CHECK(with(Key::Period).single_step);
  CHECK(with(Key::F).frame_view);
  CHECK(with(Key::H).toggle_panels);
  CHECK(with(Key::F1).toggle_help);
  CHECK(with(Key::N).toggle_nodes);
  CHECK(with(Key::P).toggle_points);
  CHECK(with(Key::Digit1).colour_map == 0);
  CHECK(with(Key::Digit4).colour_map == 3);
  CHECK(with(Key::Space).colour_map == -1);
  CHECK(with(Key::Escape, true).close);
  CHECK_FALSE(with(Key::Escape, true).quit);
  CHECK(with(Key::Escape, false).quit);
  CHECK_FALSE(with(Key::Z).undo);
  Input undo;
  undo.ctrl = true;
  undo.press(Key::Z);
  CHECK(controls.read(undo, false).undo);
}

TEST_CASE("Presses between two pictures are counted: what switches twice stays, undo goes back so often", "[input]") {
  Controls controls;
  Input input;
  input.press(Key::X);
  input.press(Key::X);
  input.press(Key::G);
  input.press(Key::Period);
  input.press(Key::Period);
  input.ctrl = true;
  input.press(Key::Z);
  input.press(Key::Z);
  input.ctrl = false;  // up again by now
  const Actions actions = controls.read(input, false);
  CHECK_FALSE(actions.toggle_section);
  CHECK(actions.toggle_ghost);
  CHECK(actions.single_step == 2);
  CHECK(actions.undo == 2);
}

TEST_CASE(
    "On the skin a drag leads the probe, and its wheel presses; beside it and with the middle button it turns the view",
    "[input]") {
  Controls controls;
  Input input = moved(3, 5);
  input.left = input.on_skin = true;
  input.wheel = 2;
  Actions actions = controls.read(input, false);
  CHECK(controls.drag() == Drag::Glide);
  CHECK(actions.glide);
  CHECK(actions.push_tool_notches == 2);
  CHECK(actions.zoom == 0);
  input.on_skin = false;  // it goes on past the organ's edge
  CHECK(controls.read(input, false).glide);

  Controls others;
  Input middle = moved(3, 5);
  middle.middle = middle.on_skin = true;
  others.read(middle, false);
  CHECK(others.drag() == Drag::Orbit);

  Controls turning;
  Input alt = moved(3, 5);
  alt.left = alt.alt = alt.on_skin = true;
  turning.read(alt, false);
  CHECK(turning.read(alt, false).turn_tool == Eigen::Vector2d(3, 5));
}

TEST_CASE("What presses, chooses and marks has a key of its own", "[input]") {
  Controls controls;
  Input input;
  for (const Key key :
       {Key::End, Key::Home, Key::E, Key::B, Key::B, Key::Plus, Key::Plus, Key::Minus, Key::Enter, Key::U})
    input.press(key);
  const Actions actions = controls.read(input, false);
  CHECK((actions.press && actions.lift && actions.toggle_engineer && actions.use_probe));
  CHECK(actions.next_shape == 2);
  CHECK(actions.radius_steps == 1);
  CHECK(actions.next_hardness == 1);
  CHECK(keyFromGlfw(GLFW_KEY_KP_ADD) == Key::Plus);
}

TEST_CASE("Taken hold of, a free probe is moved, pushed and tilted by the mouse alone", "[input]") {
  Input input = moved(3, 5);
  input.left = input.on_probe = input.free_probe = input.on_skin = true;
  input.wheel = 1;
  Controls left;
  left.read(input, false);
  CHECK(left.drag() == Drag::MoveTool);
  const Actions actions = left.read(input, false);
  CHECK(actions.move_tool == Eigen::Vector2d(3, 5));
  CHECK(actions.push_tool_notches == 1);
  input.free_probe = false;  // else it glides
  Controls gliding;
  gliding.read(input, false);
  CHECK(gliding.drag() == Drag::Glide);
  input.left = false;
  input.right = true;
  Controls right;
  right.read(input, false);
  CHECK(right.drag() == Drag::TurnTool);
}

TEST_CASE("The demo lets through what moves the probe and the view, and nothing that stays", "[input]") {
  Controls controls;
  Input input;
  for (int key = 0; key < static_cast<int>(Key::Count); ++key) input.press(static_cast<Key>(key));
  input.ctrl = true;
  input.press(Key::O);
  input.press(Key::S);
  const Actions actions = lockedForDemo(controls.read(input, true));
  CHECK_FALSE((actions.toggle_timeline || actions.toggle_nodes || actions.toggle_points || actions.toggle_panels));
  CHECK_FALSE((actions.toggle_engineer || actions.open_scene || actions.save_forces || actions.save_picture));
  CHECK_FALSE((actions.quit || actions.use_probe || actions.next_shape > 0 || actions.single_step > 0));
  CHECK((actions.press && actions.lift && actions.reset && actions.frame_view && actions.toggle_demo));
}

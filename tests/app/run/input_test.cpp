#include "app/run/input.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <utility>

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
    Motion first = controls.read(input);
    CHECK(controls.drag() == c.drag);
    CHECK(first.orbit.isZero());  // the press is no movement
    CHECK(first.pan.isZero());
    CHECK(first.move_tool.isZero());
    CHECK(first.push_tool_px == 0);
    CHECK(first.pull_begin == (c.drag == Drag::Pull));

    const Motion next = controls.read(input);
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
  controls.read(input);
  input.shift = false;       // let go early
  input.mouse_taken = true;  // and wander over a panel
  const Motion motion = controls.read(input);
  CHECK(controls.drag() == Drag::MoveTool);
  CHECK(motion.move_tool == Eigen::Vector2d(1, 0));
  input.left = false;  // and up after a last stretch, which a slow picture shows together with it
  CHECK(controls.read(input).move_tool == Eigen::Vector2d(1, 0));
  CHECK(controls.drag() == Drag::None);
  CHECK(controls.read(input).move_tool.isZero());
}

TEST_CASE("What belongs to a panel does not reach the view", "[input]") {
  Controls controls;
  Input input = moved(4, 4);
  input.left = true;
  input.mouse_taken = true;
  input.wheel = 1;
  controls.read(input);
  input.mouse_taken = false;  // dragged off the panel, e.g. a slider's end
  input.wheel = 0;
  const Motion motion = controls.read(input);
  CHECK(controls.drag() == Drag::Panel);
  CHECK(motion.orbit.isZero());

  Controls others;
  Input wheel;
  wheel.wheel = 1;
  wheel.mouse_taken = true;
  CHECK(others.read(wheel).zoom == 0);
  wheel.mouse_taken = false;
  CHECK(others.read(wheel).zoom == 1);

  Input typing;
  typing.keys_taken = true;
  typing.press(GLFW_KEY_BACKSPACE);
  typing.press(GLFW_KEY_ESCAPE);
  CHECK(askedByKeys(typing, false, false).empty());
}

TEST_CASE("Shift turns the wheel from zooming to pushing the tool", "[input]") {
  Controls controls;
  Input input;
  input.wheel = -2;
  input.shift = true;
  const Motion motion = controls.read(input);
  CHECK(motion.zoom == 0);
  CHECK(motion.push_tool_notches == -2);
}

TEST_CASE("Each key has its action - Escape closes the help before it quits", "[input]") {
  const auto asked = [](int code, bool with_ctrl = false, bool help = false) {
    Input input;
    input.ctrl = with_ctrl;
    input.press(code);
    const UserActions actions = askedByKeys(input, help, false);
    return actions.size() == 1 ? std::optional(actions[0].kind) : std::nullopt;
  };
  for (const auto& [code, kind] : {std::pair{GLFW_KEY_SPACE, UserAction::TogglePause},
                                   {GLFW_KEY_BACKSPACE, UserAction::Reset},
                                   {GLFW_KEY_PERIOD, UserAction::SingleStep},
                                   {GLFW_KEY_F, UserAction::FrameView},
                                   {GLFW_KEY_H, UserAction::TogglePanels},
                                   {GLFW_KEY_F1, UserAction::ToggleHelp},
                                   {GLFW_KEY_N, UserAction::ToggleNodes},
                                   {GLFW_KEY_P, UserAction::TogglePoints},
                                   {GLFW_KEY_ESCAPE, UserAction::Quit},
                                   {GLFW_KEY_END, UserAction::Press},
                                   {GLFW_KEY_HOME, UserAction::Lift},
                                   {GLFW_KEY_E, UserAction::ToggleEngineer},
                                   {GLFW_KEY_KP_ENTER, UserAction::UseProbe}}) {
    INFO(code);
    CHECK(asked(code) == kind);
  }
  CHECK(asked(GLFW_KEY_ESCAPE, false, true) == UserAction::Close);
  CHECK(asked(GLFW_KEY_Z, true) == UserAction::Undo);
  for (const int code : {GLFW_KEY_Z, GLFW_KEY_S, GLFW_KEY_O, GLFW_KEY_Q, GLFW_KEY_UNKNOWN}) CHECK_FALSE(asked(code));
  Input fourth;
  fourth.press(GLFW_KEY_4);
  CHECK(askedByKeys(fourth, false, false)[0].value == 3);
}

TEST_CASE("Presses between two pictures are counted: what switches twice stays, undo goes back so often", "[input]") {
  Input input;
  for (const int code : {GLFW_KEY_X, GLFW_KEY_X, GLFW_KEY_G, GLFW_KEY_PERIOD, GLFW_KEY_PERIOD, GLFW_KEY_B, GLFW_KEY_B,
                         GLFW_KEY_EQUAL, GLFW_KEY_KP_ADD, GLFW_KEY_MINUS, GLFW_KEY_U, GLFW_KEY_END, GLFW_KEY_END})
    input.press(code);
  input.ctrl = true;
  input.press(GLFW_KEY_Z);
  input.press(GLFW_KEY_Z);
  input.ctrl = false;  // up again by now
  const UserActions actions = askedByKeys(input, false, false);
  const auto times = [&](UserAction::Kind kind) {
    return std::count_if(actions.begin(), actions.end(), [=](const UserAction& a) { return a.kind == kind; });
  };
  CHECK(times(UserAction::ToggleSection) == 0);
  CHECK(times(UserAction::ToggleGhost) == 1);
  CHECK(times(UserAction::SingleStep) == 2);
  CHECK(times(UserAction::Undo) == 2);
  CHECK(times(UserAction::NextShape) == 2);
  CHECK(times(UserAction::Larger) - times(UserAction::Smaller) == 1);
  CHECK(times(UserAction::NextHardness) == 1);
  CHECK(times(UserAction::Press) == 1);
}

TEST_CASE(
    "On the skin a drag leads the probe, and its wheel presses - beside it and with the middle button it turns the "
    "view",
    "[input]") {
  Controls controls;
  Input input = moved(3, 5);
  input.left = input.on_skin = true;
  input.wheel = 2;
  Motion motion = controls.read(input);
  CHECK(controls.drag() == Drag::Glide);
  CHECK(motion.glide);
  CHECK(motion.push_tool_notches == 2);
  CHECK(motion.zoom == 0);
  input.on_skin = false;  // it goes on past the organ's edge
  CHECK(controls.read(input).glide);

  Controls others;
  Input middle = moved(3, 5);
  middle.middle = middle.on_skin = true;
  others.read(middle);
  CHECK(others.drag() == Drag::Orbit);

  Controls turning;
  Input alt = moved(3, 5);
  alt.left = alt.alt = alt.on_skin = true;
  turning.read(alt);
  CHECK(turning.read(alt).turn_tool == Eigen::Vector2d(3, 5));
}

TEST_CASE("Taken hold of, a free probe is moved, pushed and tilted by the mouse alone", "[input]") {
  Input input = moved(3, 5);
  input.left = input.on_probe = input.free_probe = input.on_skin = true;
  input.wheel = 1;
  Controls left;
  left.read(input);
  CHECK(left.drag() == Drag::MoveTool);
  const Motion motion = left.read(input);
  CHECK(motion.move_tool == Eigen::Vector2d(3, 5));
  CHECK(motion.push_tool_notches == 1);
  input.free_probe = false;  // else it glides
  Controls gliding;
  gliding.read(input);
  CHECK(gliding.drag() == Drag::Glide);
  input.left = false;
  input.right = true;
  Controls right;
  right.read(input);
  CHECK(right.drag() == Drag::TurnTool);
}

TEST_CASE("The demo lets through what moves the probe and the view, and nothing that stays", "[input]") {
  Input input;
  input.ctrl = true;
  for (int code = GLFW_KEY_SPACE; code <= GLFW_KEY_LAST; ++code) input.press(code);
  const UserActions actions = askedByKeys(input, true, true);
  using A = UserAction;
  for (const A::Kind kind :
       {A::ToggleTimeline, A::ToggleNodes, A::TogglePoints, A::TogglePanels, A::ToggleEngineer, A::AskForFile,
        A::SaveForces, A::SavePicture, A::Quit, A::UseProbe, A::NextShape, A::Larger, A::Smaller, A::SingleStep}) {
    INFO(kind);
    CHECK_FALSE(asks(actions, kind));
    CHECK(asks(askedByKeys(input, false, false), kind));
  }
  for (const A::Kind kind : {A::Press, A::Lift, A::Reset, A::FrameView, A::ToggleDemo}) CHECK(asks(actions, kind));
}

#include "app/run/input.h"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <cstddef>

namespace palpate::app {

namespace {

Drag beginningDrag(const Input& input) {
  if (!input.left && !input.right && !input.middle) return Drag::None;
  if (input.mouse_taken) return Drag::Panel;
  if (input.middle) return Drag::Orbit;
  if (input.left && input.ctrl) return Drag::Pull;
  if (input.on_probe && !input.shift && !input.alt) {  // taken hold of: all of it by the mouse alone
    if (input.right) return Drag::TurnTool;
    if (input.free_probe) return Drag::MoveTool;
  }
  if (input.shift) return input.left ? Drag::MoveTool : Drag::PushTool;
  if (input.left && input.alt) return Drag::TurnTool;
  if (input.left && input.on_skin) return Drag::Glide;
  return input.left ? Drag::Orbit : Drag::Pan;
}

/// How often a key counts that went down several times between two pictures; Switch: twice changes nothing.
enum class Counts { Once, Switch, Each };
struct KeyAction {
  int code;
  UserAction::Kind action;
  Counts counts = Counts::Once;
  bool with_ctrl = false, in_demo = true;
  double value = 0;
};

constexpr bool plain = false, ctrl = true, not_in_demo = false;
/// Carried out in this order.
constexpr KeyAction key_actions[] = {
    {GLFW_KEY_1, UserAction::ShowColours, Counts::Once, plain, true, 0},
    {GLFW_KEY_2, UserAction::ShowColours, Counts::Once, plain, true, 1},
    {GLFW_KEY_3, UserAction::ShowColours, Counts::Once, plain, true, 2},
    {GLFW_KEY_4, UserAction::ShowColours, Counts::Once, plain, true, 3},
    {GLFW_KEY_N, UserAction::ToggleNodes, Counts::Switch, plain, not_in_demo},
    {GLFW_KEY_P, UserAction::TogglePoints, Counts::Switch, plain, not_in_demo},
    {GLFW_KEY_H, UserAction::TogglePanels, Counts::Switch, plain, not_in_demo},
    {GLFW_KEY_F1, UserAction::ToggleHelp, Counts::Switch},
    {GLFW_KEY_O, UserAction::AskForFile, Counts::Once, ctrl, not_in_demo},
    {GLFW_KEY_T, UserAction::ToggleTimeline, Counts::Switch, plain, not_in_demo},
    {GLFW_KEY_F11, UserAction::ToggleFullScreen, Counts::Switch},
    {GLFW_KEY_G, UserAction::ToggleGhost, Counts::Switch},
    {GLFW_KEY_X, UserAction::ToggleSection, Counts::Switch},
    {GLFW_KEY_F, UserAction::FrameView},
    {GLFW_KEY_SPACE, UserAction::TogglePause, Counts::Switch},
    {GLFW_KEY_PERIOD, UserAction::SingleStep, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_BACKSPACE, UserAction::Reset},
    {GLFW_KEY_Z, UserAction::Undo, Counts::Each, ctrl},
    {GLFW_KEY_E, UserAction::ToggleEngineer, Counts::Switch, plain, not_in_demo},
    {GLFW_KEY_B, UserAction::NextShape, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_EQUAL, UserAction::Larger, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_KP_ADD, UserAction::Larger, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_MINUS, UserAction::Smaller, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_KP_SUBTRACT, UserAction::Smaller, Counts::Each, plain, not_in_demo},
    {GLFW_KEY_ENTER, UserAction::UseProbe, Counts::Once, plain, not_in_demo},
    {GLFW_KEY_KP_ENTER, UserAction::UseProbe, Counts::Once, plain, not_in_demo},
    {GLFW_KEY_END, UserAction::Press},
    {GLFW_KEY_HOME, UserAction::Lift},
    {GLFW_KEY_F10, UserAction::ToggleDemo, Counts::Switch},
    {GLFW_KEY_U, UserAction::NextHardness, Counts::Each},
    {GLFW_KEY_M, UserAction::Mark},
    {GLFW_KEY_F12, UserAction::SavePicture, Counts::Once, plain, not_in_demo},
    {GLFW_KEY_S, UserAction::SaveForces, Counts::Once, ctrl, not_in_demo},
};

}  // namespace

Motion Controls::read(const Input& input) {
  Motion motion;
  const Drag before = drag_;
  if (!input.left && !input.right && !input.middle)
    drag_ = Drag::None;
  else if (drag_ == Drag::None)
    drag_ = beginningDrag(input);
  const bool began = before == Drag::None && drag_ != Drag::None, ended = before != Drag::None && drag_ == Drag::None;

  // The press itself is no movement: the pointer may have come from anywhere. What was moved until the button came up
  // is, and of a quick drag all of it when pictures are slow.
  const Eigen::Vector2d moved = began ? Eigen::Vector2d(0, 0) : input.mouse_delta;
  switch (ended ? before : drag_) {
    case Drag::None:
    case Drag::Panel:
      break;
    case Drag::Orbit:
      motion.orbit = moved;
      break;
    case Drag::Pan:
      motion.pan = moved;
      break;
    case Drag::MoveTool:
      motion.move_tool = moved;
      break;
    case Drag::PushTool:
      motion.push_tool_px = moved.y();
      break;
    case Drag::Glide:
      motion.glide = true;
      break;
    case Drag::TurnTool:
      motion.turn_tool = moved;
      break;
    case Drag::Pull:
      motion.pull_begin = began;
      motion.pulling = !ended;
      break;
  }
  motion.pick_point = input.double_click && drag_ == Drag::Orbit;
  const bool pushes = input.shift || drag_ == Drag::Glide || drag_ == Drag::MoveTool;
  if (!input.mouse_taken) (pushes ? motion.push_tool_notches : motion.zoom) = input.wheel;

  if (input.keys_taken) return motion;
  motion.tool_keys = input.arrows;
  motion.turn_keys = input.tilt;
  if (!input.ctrl) motion.jaws_keys = input.jaws;
  motion.tapped = input.tapped;
  return motion;
}

UserActions askedByKeys(const Input& input, bool something_open, bool demo) {
  UserActions asked;
  const bool escape = input.presses.count(GLFW_KEY_ESCAPE) > 0;
  if (escape && something_open) asked.push_back({UserAction::Close});  // also out of a text field
  if (input.keys_taken) return asked;
  for (const KeyAction& key : key_actions) {
    const int downs = input.presses.count(key.code, key.with_ctrl);
    const int times = key.counts == Counts::Each     ? downs
                      : key.counts == Counts::Switch ? downs % 2
                                                     : std::min(downs, 1);
    if (key.in_demo || !demo) asked.insert(asked.end(), static_cast<std::size_t>(times), {key.action, key.value});
  }
  if (escape && !something_open) asked.push_back({UserAction::Quit});
  return asked;
}

Input inputFromImGui(const KeyPresses& presses) {
  const ImGuiIO& io = ImGui::GetIO();
  Input input;
  input.mouse = {io.MousePos.x, io.MousePos.y};
  input.mouse_delta = {io.MouseDelta.x, io.MouseDelta.y};
  // Shift turns the wheel sideways on some systems.
  input.wheel = io.MouseWheel != 0 ? io.MouseWheel : io.KeyShift ? io.MouseWheelH : 0;
  input.left = io.MouseDown[0];
  input.right = io.MouseDown[1];
  input.middle = io.MouseDown[2];
  input.double_click = io.MouseDoubleClicked[0];
  input.shift = io.KeyShift;
  input.ctrl = io.KeyCtrl;
  input.alt = io.KeyAlt;
  input.mouse_taken = io.WantCaptureMouse;
  input.keys_taken = io.WantTextInput;
  input.presses = presses;

  bool held = false;
  const auto isAsked = [&](int code) {
    const std::vector<int>& taps = presses.taps();
    if (std::find(taps.begin(), taps.end(), code) != taps.end()) return true;
    held |= ImGui::IsKeyDown(code);
    return ImGui::IsKeyDown(code);
  };
  const auto axis = [&](int minus, int plus) { return (isAsked(plus) ? 1.0 : 0.0) - (isAsked(minus) ? 1.0 : 0.0); };
  input.arrows = {axis(GLFW_KEY_LEFT, GLFW_KEY_RIGHT), axis(GLFW_KEY_DOWN, GLFW_KEY_UP),
                  axis(GLFW_KEY_PAGE_DOWN, GLFW_KEY_PAGE_UP)};
  input.tilt = {axis(GLFW_KEY_J, GLFW_KEY_L), axis(GLFW_KEY_K, GLFW_KEY_I)};
  input.jaws = axis(GLFW_KEY_C, GLFW_KEY_V);
  input.tapped = !held;
  input.anything = input.left || input.right || input.middle || input.wheel != 0 || !input.mouse_delta.isZero(0) ||
                   !presses.taps().empty() ||
                   std::any_of(std::begin(io.KeysDown), std::end(io.KeysDown), [](bool down) { return down; });
  return input;
}

}  // namespace palpate::app

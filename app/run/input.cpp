#include "app/run/input.h"

#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

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

}  // namespace

Actions Controls::read(const Input& input, bool something_open) {
  Actions actions;

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
      actions.orbit = moved;
      break;
    case Drag::Pan:
      actions.pan = moved;
      break;
    case Drag::MoveTool:
      actions.move_tool = moved;
      break;
    case Drag::PushTool:
      actions.push_tool_px = moved.y();
      break;
    case Drag::Glide:
      actions.glide = true;
      break;
    case Drag::TurnTool:
      actions.turn_tool = moved;
      break;
    case Drag::Pull:
      actions.pull_begin = began;
      actions.pulling = !ended;
      break;
  }
  actions.pick_point = input.double_click && drag_ == Drag::Orbit;
  const bool pushes = input.shift || drag_ == Drag::Glide || drag_ == Drag::MoveTool;
  if (!input.mouse_taken) (pushes ? actions.push_tool_notches : actions.zoom) = input.wheel;

  actions.close = input.wasPressed(Key::Escape) && something_open;  // also out of a text field
  if (input.keys_taken) return actions;
  actions.toggle_pause = input.switches(Key::Space);
  actions.reset = input.wasPressed(Key::Backspace);
  actions.undo = input.presses.countWithCtrl(Key::Z);
  actions.single_step = input.presses.count(Key::Period);
  actions.frame_view = input.wasPressed(Key::F);
  actions.toggle_panels = input.switches(Key::H);
  actions.toggle_help = input.switches(Key::F1);
  actions.quit = input.wasPressed(Key::Escape) && !something_open;
  actions.open_scene = input.presses.countWithCtrl(Key::O) > 0;
  actions.save_forces = input.presses.countWithCtrl(Key::S) > 0;
  actions.save_picture = input.wasPressed(Key::F12);
  actions.toggle_full_screen = input.switches(Key::F11);
  actions.toggle_demo = input.switches(Key::F10);
  actions.toggle_section = input.switches(Key::X);
  actions.toggle_ghost = input.switches(Key::G);
  actions.mark = input.wasPressed(Key::M);
  actions.toggle_nodes = input.switches(Key::N);
  actions.toggle_timeline = input.switches(Key::T);
  actions.toggle_points = input.switches(Key::P);
  actions.toggle_engineer = input.switches(Key::E);
  actions.press = input.wasPressed(Key::End);
  actions.lift = input.wasPressed(Key::Home);
  actions.use_probe = input.wasPressed(Key::Enter);
  actions.next_shape = input.presses.count(Key::B);
  actions.next_hardness = input.presses.count(Key::U);
  actions.radius_steps = input.presses.count(Key::Plus) - input.presses.count(Key::Minus);
  for (int k = 0; k < 4; ++k)
    if (input.wasPressed(static_cast<Key>(static_cast<int>(Key::Digit1) + k))) actions.colour_map = k;
  actions.tool_keys = input.arrows;
  actions.turn_keys = input.tilt;
  if (!input.ctrl) actions.jaws_keys = input.jaws;
  actions.tapped = input.tapped;
  return actions;
}

Actions lockedForDemo(Actions actions) {
  actions.toggle_nodes = actions.toggle_points = actions.toggle_timeline = actions.toggle_panels = false;
  actions.toggle_engineer = actions.open_scene = actions.save_picture = actions.save_forces = false;
  actions.next_shape = actions.radius_steps = 0;
  actions.use_probe = actions.pick_point = actions.quit = false;
  actions.single_step = 0;
  return actions;
}

std::optional<Key> keyFromGlfw(int code) {
  // Three of them have two codes.
  static constexpr std::array<std::pair<int, Key>, static_cast<std::size_t>(Key::Count) + 3> keys{
      {{GLFW_KEY_SPACE, Key::Space},
       {GLFW_KEY_BACKSPACE, Key::Backspace},
       {GLFW_KEY_PERIOD, Key::Period},
       {GLFW_KEY_F, Key::F},
       {GLFW_KEY_H, Key::H},
       {GLFW_KEY_F1, Key::F1},
       {GLFW_KEY_ESCAPE, Key::Escape},
       {GLFW_KEY_1, Key::Digit1},
       {GLFW_KEY_2, Key::Digit2},
       {GLFW_KEY_3, Key::Digit3},
       {GLFW_KEY_4, Key::Digit4},
       {GLFW_KEY_N, Key::N},
       {GLFW_KEY_P, Key::P},
       {GLFW_KEY_Z, Key::Z},
       {GLFW_KEY_O, Key::O},
       {GLFW_KEY_S, Key::S},
       {GLFW_KEY_G, Key::G},
       {GLFW_KEY_X, Key::X},
       {GLFW_KEY_M, Key::M},
       {GLFW_KEY_T, Key::T},
       {GLFW_KEY_B, Key::B},
       {GLFW_KEY_E, Key::E},
       {GLFW_KEY_U, Key::U},
       {GLFW_KEY_MINUS, Key::Minus},
       {GLFW_KEY_EQUAL, Key::Plus},
       {GLFW_KEY_KP_SUBTRACT, Key::Minus},
       {GLFW_KEY_KP_ADD, Key::Plus},
       {GLFW_KEY_ENTER, Key::Enter},
       {GLFW_KEY_KP_ENTER, Key::Enter},
       {GLFW_KEY_HOME, Key::Home},
       {GLFW_KEY_END, Key::End},
       {GLFW_KEY_F10, Key::F10},
       {GLFW_KEY_F11, Key::F11},
       {GLFW_KEY_F12, Key::F12}}};
  for (const auto& [glfw_code, key] : keys)
    if (glfw_code == code) return key;
  return {};
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

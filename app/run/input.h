#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace palpate::app {

/// The keys that mean something in the view; letters are those of MuJoCo's simulate where it has them.
enum class Key : std::uint8_t {
  Space,
  Backspace,
  Period,
  F,
  H,
  F1,
  Escape,
  Digit1,
  Digit2,
  Digit3,
  Digit4,
  N,
  P,
  Z,
  O,
  S,
  G,
  X,
  M,
  T,
  B,
  E,
  U,
  Minus,
  Plus,
  Enter,
  Home,
  End,
  F10,
  F11,
  F12,
  Count
};

/// What went down on the keyboard since the last frame: counted as the events come, so that nothing is lost however
/// slowly pictures follow each other.
class KeyPresses {
 public:
  void add(Key key, bool with_ctrl) { ++(with_ctrl ? with_ctrl_ : plain_)[static_cast<std::size_t>(key)]; }
  /// A key went down and is up again, by its GLFW code.
  void addTap(int code) { taps_.push_back(code); }

  int count(Key key) const { return plain_[static_cast<std::size_t>(key)] + with_ctrl_[static_cast<std::size_t>(key)]; }
  int countWithCtrl(Key key) const { return with_ctrl_[static_cast<std::size_t>(key)]; }
  const std::vector<int>& taps() const { return taps_; }

 private:
  std::array<int, static_cast<std::size_t>(Key::Count)> plain_{}, with_ctrl_{};
  std::vector<int> taps_;
};

/// What mouse and keyboard did since the last frame.
struct Input {
  Eigen::Vector2d mouse{0, 0};                       // px, from the window's top left corner
  Eigen::Vector2d mouse_delta{0, 0};                 // px
  double wheel = 0;                                  // notches, away from the user positive
  bool left = false, right = false, middle = false;  // buttons held
  bool double_click = false;                         // left button
  bool shift = false, ctrl = false, alt = false;
  bool on_skin = false;             // the pointer is over the skin, and the probe glides there
  bool on_probe = false;            // it is over the probe
  bool free_probe = false;          // which is moved freely
  bool mouse_taken = false;         // the pointer is over a panel
  bool keys_taken = false;          // a panel is being typed into
  KeyPresses presses;               // what went down since the last frame
  Eigen::Vector3d arrows{0, 0, 0};  // held keys, -1..1: Left/Right, Down/Up, PageDown/PageUp
  Eigen::Vector2d tilt{0, 0};       // held keys, -1..1: J/L, K/I
  double jaws = 0;                  // held keys, -1..1: C/V
  bool tapped = false;              // all of these are up again by now
  bool anything = false;            // somebody is there

  bool wasPressed(Key key) const { return presses.count(key) > 0; }
  /// What a key that switches something asks for: pressed twice it changes nothing.
  bool switches(Key key) const { return presses.count(key) % 2 == 1; }
  void press(Key key) { presses.add(key, ctrl); }
};

/// What a held mouse button is doing. It is settled when the button goes down and
/// stays so until it comes up, whatever the modifiers or the pointer do meanwhile.
enum class Drag : std::uint8_t { None, Panel, Orbit, Pan, Pull, MoveTool, PushTool, Glide, TurnTool };

/// What one frame's input asks for.
struct Actions {
  bool toggle_pause = false, reset = false;
  int undo = 0, single_step = 0;  // so many
  bool frame_view = false, toggle_panels = false, toggle_help = false;
  bool close = false, quit = false;  // close: what is open
  bool open_scene = false, save_picture = false, save_forces = false;
  bool toggle_full_screen = false, toggle_demo = false, toggle_section = false, toggle_ghost = false, mark = false;
  bool toggle_nodes = false, toggle_points = false, toggle_timeline = false, toggle_engineer = false;
  bool press = false, lift = false, use_probe = false;
  int next_shape = 0, next_hardness = 0, radius_steps = 0;  // so many
  int colour_map = -1;                                      // 0..3, -1: no change
  Eigen::Vector2d orbit{0, 0}, pan{0, 0};                   // px
  double zoom = 0;                                          // notches
  Eigen::Vector2d move_tool{0, 0};                          // px in the view plane
  double push_tool_px = 0;                                  // px along the tool's axis, into the tissue positive
  double push_tool_notches = 0;                             // the same by wheel
  Eigen::Vector3d tool_keys{0, 0, 0};                       // -1..1: right, away from the viewer, out of the tissue
  Eigen::Vector2d turn_keys{0, 0};                          // -1..1: to the right, away from the viewer
  double jaws_keys = 0;                                     // -1..1: close, open
  bool tapped = false;                                      // these keys were tapped, and are not held
  Eigen::Vector2d turn_tool{0, 0};                          // px
  bool glide = false;                                       // the pointer leads the probe over the skin
  bool pick_point = false;                                  // show the support of the point under the pointer
  bool pull_begin = false;                                  // take hold of the skin under the pointer
  bool pulling = false;                                     // the pointer drags what was taken hold of
};

/// What the demo lets through: nothing that leaves something open, shown or paused behind for those who come next, or
/// writes a file.
Actions lockedForDemo(Actions actions);

/// Turns input into actions; keeps nothing but the present drag.
class Controls {
 public:
  /// @param something_open  that Escape closes before it quits
  Actions read(const Input& input, bool something_open);
  Drag drag() const { return drag_; }

 private:
  Drag drag_ = Drag::None;
};

/// The meaning of a GLFW key code, if it has one here.
std::optional<Key> keyFromGlfw(int code);

/// The input that ImGui gathered for the present frame, with the keys that went down since the last one: ImGui knows
/// which keys are down, and so misses those that are up again before a slow frame ends.
Input inputFromImGui(const KeyPresses& presses);

}  // namespace palpate::app

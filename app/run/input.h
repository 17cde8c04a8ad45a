#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "app/panels/user_action.h"

namespace palpate::app {

/// What went down on the keyboard since the last frame: counted as the events come, so that nothing is lost however
/// slowly pictures follow each other. Keys by their GLFW codes.
class KeyPresses {
 public:
  void add(int code, bool with_ctrl) { downs_.push_back({code, with_ctrl}); }
  /// A key went down and is up again.
  void addTap(int code) { taps_.push_back(code); }

  int count(int code, bool only_with_ctrl = false) const {
    return static_cast<int>(std::count_if(downs_.begin(), downs_.end(), [=](const Down& down) {
      return down.code == code && (down.with_ctrl || !only_with_ctrl);
    }));
  }
  const std::vector<int>& taps() const { return taps_; }

 private:
  struct Down {
    int code;
    bool with_ctrl;
  };
  std::vector<Down> downs_;
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

  void press(int code) { presses.add(code, ctrl); }
};

/// What a held mouse button is doing. It is settled when the button goes down and
/// stays so until it comes up, whatever the modifiers or the pointer do meanwhile.
enum class Drag : std::uint8_t { None, Panel, Orbit, Pan, Pull, MoveTool, PushTool, Glide, TurnTool };

/// What one frame's input moves.
struct Motion {
  Eigen::Vector2d orbit{0, 0}, pan{0, 0};  // px
  double zoom = 0;                         // notches
  Eigen::Vector2d move_tool{0, 0};         // px in the view plane
  double push_tool_px = 0;                 // px along the tool's axis, into the tissue positive
  double push_tool_notches = 0;            // the same by wheel
  Eigen::Vector3d tool_keys{0, 0, 0};      // -1..1: right, away from the viewer, out of the tissue
  Eigen::Vector2d turn_keys{0, 0};         // -1..1: to the right, away from the viewer
  double jaws_keys = 0;                    // -1..1: close, open
  bool tapped = false;                     // these keys were tapped, and are not held
  Eigen::Vector2d turn_tool{0, 0};         // px
  bool glide = false;                      // the pointer leads the probe over the skin
  bool pick_point = false;                 // show the support of the point under the pointer
  bool pull_begin = false;                 // take hold of the skin under the pointer
  bool pulling = false;                    // the pointer drags what was taken hold of
};

/// Turns input into motion; keeps nothing but the present drag.
class Controls {
 public:
  Motion read(const Input& input);
  Drag drag() const { return drag_; }

 private:
  Drag drag_ = Drag::None;
};

/// What the keys ask for; letters are those of MuJoCo's simulate where it has them.
/// @param something_open  that Escape closes before it quits
/// @param demo  nothing that leaves something open, shown or paused behind for those who come next, or writes a file
UserActions askedByKeys(const Input& input, bool something_open, bool demo);

/// The input that ImGui gathered for the present frame, with the keys that went down since the last one: ImGui knows
/// which keys are down, and so misses those that are up again before a slow frame ends.
Input inputFromImGui(const KeyPresses& presses);

}  // namespace palpate::app

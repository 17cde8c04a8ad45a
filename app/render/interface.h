#pragma once

#include <span>
#include <vector>

#include "app/render/theme.h"

struct GLFWwindow;
struct ImGuiContext;

namespace palpate::app {

/// Dear ImGui on the current OpenGL context, with or without a window: fonts, style and
/// the frame around the panels. One thread, one context.
class Interface {
 public:
  /// @param window  its events drive the panels; null: off-screen
  /// @param scale   content scale of the screen
  /// Throws std::runtime_error where the context can't draw panels.
  Interface(GLFWwindow* window, float scale);
  ~Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  /// Keys (GLFW's codes) that count as down in the next frame though they may be up again: what was only tapped since
  /// the last one would else never reach a text field.
  void hold(std::span<const int> codes);

  /// Begins a frame. Off-screen the size is given here; a window knows its own.
  void begin(int width = 0, int height = 0);

  /// Draws the frame into the framebuffer that is bound.
  void end();

  const Theme& theme() const { return theme_; }

 private:
  GLFWwindow* window_;
  ImGuiContext* context_;
  Theme theme_;
  std::vector<int> held_;  // keys that are up, and count as down in the present frame
};

}  // namespace palpate::app

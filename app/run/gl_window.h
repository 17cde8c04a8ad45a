#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/run/composition.h"
#include "app/run/input.h"
#include "app/run/options.h"

struct GLFWwindow;

namespace palpate::app {

/// A window with a current OpenGL 3.3 core context, and what GLFW tells about it between two pictures.
/// One at a time; main thread.
class GlWindow {
 public:
  /// Throws std::runtime_error with GLFW's own words where there is no display or no such context.
  GlWindow(const Options& options, const std::string& title);
  ~GlWindow();
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* handle() const { return handle_; }
  void setTitle(const std::string& title);

  /// The keys that went down since the last call.
  KeyPresses takePressed();
  /// The files that were dropped on it since the last call.
  std::vector<std::string> takeDropped();

  CanvasSize size() const;
  /// Content scale that the window system has not already put into the pixel ratio.
  float interfaceScale() const;
  bool visible() const;

  /// To the whole screen, and back to where it was.
  void toggleFullScreen();
  bool fullScreen() const;

  bool closeAsked() const;
  void forgetClose();
  void poll();
  void waitFor(double seconds);
  void show();  // what was drawn

 private:
  GLFWwindow* handle_ = nullptr;
  KeyPresses pressed_;
  std::vector<int> went_down_;  // GLFW codes
  std::vector<std::string> dropped_;
  int place_[4] = {0, 0, 0, 0};  // x, y, width, height before full screen
};

/// Throws std::runtime_error where there is no display: before anything takes time.
void requireDisplay();

}  // namespace palpate::app

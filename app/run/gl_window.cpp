#include "app/run/gl_window.h"

#include <epoxy/gl.h>
// After epoxy, which defines the OpenGL functions.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace palpate::app {

namespace {

constexpr int min_width = 640, min_height = 400;  // screen units

std::string& lastGlfwError() {
  static std::string text;
  return text;
}

[[noreturn]] void noWindow(const std::string& problem) {
  std::string text = problem;
  if (!lastGlfwError().empty()) text += " (" + lastGlfwError() + ")";
  throw std::runtime_error(text + "; palpate SCENE --offscreen runs without a display");
}

/// GLFW for as long as this lives. Made before the model, so that a missing display is
/// told at once.
struct Glfw {
  Glfw() {
    glfwSetErrorCallback([](int, const char* text) { lastGlfwError() = text; });
    if (glfwInit() != GLFW_TRUE) noWindow("no display");
  }
  ~Glfw() { glfwTerminate(); }
  Glfw(const Glfw&) = delete;
  Glfw& operator=(const Glfw&) = delete;
};

void useGlfw() { static const Glfw glfw; }

}  // namespace

GlWindow::GlWindow(const Options& options, const std::string& title) {
  useGlfw();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);  // the renderer brings its own
  handle_ = glfwCreateWindow(options.width, options.height, title.c_str(), nullptr, nullptr);
  if (handle_ == nullptr) noWindow("no OpenGL 3.3 core context");
  glfwMakeContextCurrent(handle_);
  glfwSetWindowSizeLimits(handle_, min_width, min_height, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwSwapInterval(1);
  // Set before ImGui's own callback, which then calls this one first.
  glfwSetWindowUserPointer(handle_, this);
  glfwSetKeyCallback(handle_, [](GLFWwindow* window, int code, int, int action, int modifiers) {
    auto& self = *static_cast<GlWindow*>(glfwGetWindowUserPointer(window));
    // Held, '.' goes on: a run in slow motion.
    if (action == GLFW_PRESS || (action == GLFW_REPEAT && code == GLFW_KEY_PERIOD))
      self.pressed_.add(code, (modifiers & GLFW_MOD_CONTROL) != 0);
    if (action == GLFW_PRESS) self.went_down_.push_back(code);
  });
  glfwSetDropCallback(handle_, [](GLFWwindow* window, int count, const char** paths) {
    auto& self = *static_cast<GlWindow*>(glfwGetWindowUserPointer(window));
    self.dropped_.insert(self.dropped_.end(), paths, paths + count);
  });
}

GlWindow::~GlWindow() { glfwDestroyWindow(handle_); }

void GlWindow::setTitle(const std::string& title) { glfwSetWindowTitle(handle_, title.c_str()); }

KeyPresses GlWindow::takePressed() {
  KeyPresses pressed = std::exchange(pressed_, {});
  for (const int code : std::exchange(went_down_, {}))
    if (glfwGetKey(handle_, code) == GLFW_RELEASE) pressed.addTap(code);
  return pressed;
}

std::vector<std::string> GlWindow::takeDropped() { return std::exchange(dropped_, {}); }

CanvasSize GlWindow::size() const {
  CanvasSize size;
  int pixel_width = 0, pixel_height = 0;
  glfwGetWindowSize(handle_, &size.width, &size.height);
  glfwGetFramebufferSize(handle_, &pixel_width, &pixel_height);
  if (size.width > 0) size.pixel_ratio = static_cast<float>(pixel_width) / static_cast<float>(size.width);
  return size;
}

float GlWindow::interfaceScale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(handle_, &x, &y);
  return std::max(1.0F, std::min(x, y) / size().pixel_ratio);
}

bool GlWindow::visible() const {
  const CanvasSize now = size();
  return now.width > 0 && now.height > 0 && glfwGetWindowAttrib(handle_, GLFW_ICONIFIED) == 0;
}

bool GlWindow::fullScreen() const { return glfwGetWindowMonitor(handle_) != nullptr; }

void GlWindow::toggleFullScreen() {
  if (fullScreen()) {
    glfwSetWindowMonitor(handle_, nullptr, place_[0], place_[1], place_[2], place_[3], GLFW_DONT_CARE);
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) return;
  glfwGetWindowPos(handle_, &place_[0], &place_[1]);
  glfwGetWindowSize(handle_, &place_[2], &place_[3]);
  glfwSetWindowMonitor(handle_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool GlWindow::closeAsked() const { return glfwWindowShouldClose(handle_) != 0; }
void GlWindow::forgetClose() { glfwSetWindowShouldClose(handle_, GLFW_FALSE); }
void GlWindow::poll() { glfwPollEvents(); }
void GlWindow::waitFor(double seconds) { glfwWaitEventsTimeout(seconds); }
void GlWindow::show() { glfwSwapBuffers(handle_); }

void requireDisplay() { useGlfw(); }

}  // namespace palpate::app

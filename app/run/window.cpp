#include "app/run/window.h"

#include <epoxy/gl.h>
// After epoxy, which defines the OpenGL functions.
#include <GLFW/glfw3.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "app/render/framebuffer.h"
#include "app/render/pick.h"
#include "app/run/composition.h"
#include "app/run/frame_pace.h"
#include "app/run/input.h"
#include "app/run/tool_hand.h"
#include "base/interrupt.h"
#include "realtime/loop/thread_setup.h"

namespace palpate::app {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double hidden_wait = 0.1;               // s, between looks at the loop while the window is minimised
constexpr int min_width = 640, min_height = 400;  // screen units
constexpr double pick_pixels = 12;                // how near to the pointer an integration point must be

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

/// A window with a current OpenGL 3.3 core context.
class GlWindow {
 public:
  GlWindow(const Options& options, const std::string& title) {
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
    glfwSetKeyCallback(handle_, [](GLFWwindow* window, int code, int, int action, int) {
      auto& self = *static_cast<GlWindow*>(glfwGetWindowUserPointer(window));
      const std::optional<Key> key = keyFromGlfw(code);
      // Held, '.' goes on: a run in slow motion.
      const bool counts = action == GLFW_PRESS || (action == GLFW_REPEAT && key == Key::Period);
      if (key && counts) self.pressed_ |= 1u << static_cast<unsigned>(*key);
    });
  }
  ~GlWindow() { glfwDestroyWindow(handle_); }
  GlWindow(const GlWindow&) = delete;
  GlWindow& operator=(const GlWindow&) = delete;

  GLFWwindow* handle() const { return handle_; }

  /// The keys that went down since the last call, a bit per Key.
  std::uint32_t takePressed() { return std::exchange(pressed_, 0u); }

  CanvasSize size() const {
    CanvasSize size;
    int pixel_width = 0, pixel_height = 0;
    glfwGetWindowSize(handle_, &size.width, &size.height);
    glfwGetFramebufferSize(handle_, &pixel_width, &pixel_height);
    if (size.width > 0) size.pixel_ratio = static_cast<float>(pixel_width) / static_cast<float>(size.width);
    return size;
  }

  /// Content scale that the window system has not already put into the pixel ratio.
  float interfaceScale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(handle_, &x, &y);
    return std::max(1.0F, std::min(x, y) / size().pixel_ratio);
  }

  bool visible() const {
    const CanvasSize now = size();
    return now.width > 0 && now.height > 0 && glfwGetWindowAttrib(handle_, GLFW_ICONIFIED) == 0;
  }

 private:
  GLFWwindow* handle_ = nullptr;
  std::uint32_t pressed_ = 0;
};

/// The window's own state: what the user sees, holds and sets.
class Viewer {
 public:
  Viewer(Session& session, GlWindow& window)
      : session_(session),
        window_(window),
        renderer_(session.model(), findShaderDir()),
        ui_(window.handle(), window.interfaceScale()),
        hand_(session.model()) {
    const CanvasSize size = window.size();
    view_.camera =
        startCamera(session.model().scene, layoutFor(size.width, size.height, ui_.theme().scale, true), size);
  }

  /// One frame: input, requests to the loop, picture. False when the user quits.
  bool frame(double seconds);
  /// The present picture, drawn once more.
  Picture picture();

 private:
  Layout layout(const CanvasSize& size) const {
    return layoutFor(size.width, size.height, ui_.theme().scale, panels_.panels_shown);
  }
  void applyView(const Actions& actions, const CanvasSize& size);
  void applyRun(const Actions& actions, const Snapshot& snapshot);
  void applyTool(const Actions& actions, const Camera& camera, const Snapshot& snapshot, const CanvasSize& size,
                 double seconds);
  void applyPull(const Actions& actions, const Camera& camera, const Eigen::Vector2d& mouse, const CanvasSize& size);
  void applyRequests(const PanelRequests& requests, const Snapshot& snapshot, const CanvasSize& size);
  void reset();

  Session& session_;
  GlWindow& window_;
  Renderer renderer_;
  Interface ui_;
  ToolHand hand_;
  Controls controls_;
  View view_;
  PanelState panels_;
  std::int64_t undo_count_ = 0;  // of the last snapshot
  double frame_seconds_ = 0;     // mean of the last ones
};

void Viewer::reset() {
  session_.send(Request::simple(Request::Kind::Reset));
  hand_.toStart();
  view_.pulled_vertex = -1;
}

void Viewer::applyView(const Actions& actions, const CanvasSize& size) {
  const int height = size.pixelHeight();
  view_.camera.orbit(actions.orbit.x(), actions.orbit.y(), height);
  view_.camera.pan(actions.pan.x(), actions.pan.y(), height);
  if (actions.zoom != 0) view_.camera.zoom(actions.zoom);
  if (actions.colour_map >= 0) view_.colour_map = static_cast<ColourMap>(actions.colour_map);
  if (actions.toggle_nodes) view_.show_nodes = !view_.show_nodes;
  if (actions.toggle_points) view_.show_points = !view_.show_points;
  if (actions.toggle_panels) panels_.panels_shown = !panels_.panels_shown;
  if (actions.toggle_help) panels_.help_shown = !panels_.help_shown;
  if (actions.close_help) panels_.help_shown = false;
  if (actions.frame_view) frameOrgan(view_.camera, renderer_, layout(size), size);
}

void Viewer::applyRun(const Actions& actions, const Snapshot& snapshot) {
  using Kind = Request::Kind;
  if (actions.toggle_pause) session_.send(Request::simple(snapshot.status.paused ? Kind::Resume : Kind::Pause));
  if (actions.single_step) {
    if (!snapshot.status.paused) session_.send(Request::simple(Kind::Pause));
    session_.send(Request::simple(Kind::SingleStep));
  }
  if (actions.reset) reset();
  if (actions.undo) session_.send(Request::simple(Kind::Undo));
}

void Viewer::applyTool(const Actions& actions, const Camera& camera, const Snapshot& snapshot, const CanvasSize& size,
                       double seconds) {
  if (session_.driver() != ToolDriver::User) {
    hand_.moveTo(snapshot.tool_pose);  // so that the hand takes over where the script ends
    return;
  }
  if (std::exchange(undo_count_, snapshot.status.undo_count) != snapshot.status.undo_count) {
    hand_.moveTo(snapshot.hand_pose);  // where the tool was then
    view_.pulled_vertex = -1;
  }
  if (hand_.apply(actions, camera, size.pixelHeight(), 1e-3 * panels_.tool_speed_mm_s, seconds))
    session_.send(Request::moveTool(hand_.target()));
}

void Viewer::applyPull(const Actions& actions, const Camera& camera, const Eigen::Vector2d& mouse,
                       const CanvasSize& size) {
  const Ray ray = camera.rayThrough(mouse.x(), mouse.y(), size.pixelWidth(), size.pixelHeight());
  if (actions.pull_begin && session_.driver() == ToolDriver::User) {
    if (const auto hit = pickSkin(session_.model().skin.surface, renderer_.skinPositions(), ray)) {
      view_.pulled_vertex = hit->vertex;
      view_.pull_target = hit->position;
    }
  }
  if (view_.pulled_vertex < 0) return;
  if (!actions.pulling) {
    view_.pulled_vertex = -1;
    session_.send(Request::simple(Request::Kind::ReleasePull));
    return;
  }
  // The target stays in the plane through the first hit that faces the viewer.
  const double depth = (view_.pull_target - ray.origin).dot(camera.forward());
  const Vec3 target = ray.origin + depth / ray.direction.dot(camera.forward()) * ray.direction;
  if (actions.pull_begin || target != view_.pull_target) {
    view_.pull_target = target;
    session_.send(Request::pull(view_.pulled_vertex, target));
  }
}

void Viewer::applyRequests(const PanelRequests& requests, const Snapshot& snapshot, const CanvasSize& size) {
  Actions actions;
  actions.toggle_pause = requests.toggle_pause;
  actions.single_step = requests.single_step;
  actions.reset = requests.reset || requests.restart_script;
  actions.undo = requests.undo;
  applyRun(actions, snapshot);
  if (requests.restart_script && snapshot.status.paused) session_.send(Request::simple(Request::Kind::Resume));
  if (requests.frame_view) frameOrgan(view_.camera, renderer_, layout(size), size);
  if (requests.tool_to_start) {
    hand_.toStart();
    session_.send(Request::moveTool(hand_.target()));
  }
  if (requests.friction) session_.setFriction(*requests.friction);
  if (requests.material >= 0) session_.setStiffness(requests.material, requests.stiffness);
}

bool Viewer::frame(double seconds) {
  const CanvasSize size = window_.size();
  constexpr double share = 0.05;  // of the newest frame in the mean that is shown
  frame_seconds_ = frame_seconds_ == 0 ? seconds : frame_seconds_ + share * (seconds - frame_seconds_);
  session_.gather();
  const Snapshot& snapshot = session_.latest();
  ui_.begin();

  Input input = inputFromImGui(window_.takePressed());
  input.mouse *= size.pixel_ratio;
  input.mouse_delta *= size.pixel_ratio;
  const Actions actions = controls_.read(input, panels_.help_shown);
  applyView(actions, size);
  applyRun(actions, snapshot);
  const Camera shown = centredIn(layout(size), view_.camera, size);
  applyTool(actions, shown, snapshot, size, seconds);
  applyPull(actions, shown, input.mouse, size);
  if (actions.pick_point) {
    const Ray ray = shown.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight());
    view_.picked_point =
        pickPoint(session_.model(), snapshot, ray, pick_pixels * shown.pixelSize(shown.target, size.pixelHeight()));
  }

  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  const PanelRequests requests = drawComposition(renderer_, ui_, session_, snapshot, view_, panels_, layout(size), size,
                                                 frame_seconds_ > 0 ? 1 / frame_seconds_ : 0);
  applyRequests(requests, snapshot, size);
  return !actions.quit;
}

Picture Viewer::picture() {
  const CanvasSize size = window_.size();
  const Framebuffer framebuffer(size.pixelWidth(), size.pixelHeight());
  framebuffer.bind();
  ui_.begin();
  drawComposition(renderer_, ui_, session_, session_.latest(), view_, panels_, layout(size), size, 0);
  return framebuffer.read();
}

}  // namespace

void requireDisplay() { useGlfw(); }

void runWindow(Session& session) {
  // The loop's threads are made first: threads inherit the low priority that this one
  // then takes, and so should those of a software OpenGL only.
  session.start();
  const std::string priority = setUpViewerThread();
  GlWindow window(session.options(), "Palpate - " + session.model().scene.name);
  Viewer viewer(session, window);
  const char* opengl = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  session.log().info(std::string("OpenGL: ") + opengl + ", drawing at low priority: " + priority);
  FramePace pace(isSoftwareRenderer(opengl));

  bool shown = false;
  auto last = SteadyClock::now();
  while (glfwWindowShouldClose(window.handle()) == 0 && !session.finished() && !interrupted()) {
    if (!window.visible()) {
      glfwWaitEventsTimeout(hidden_wait);
      session.gather();
      continue;
    }
    glfwPollEvents();
    const auto now = SteadyClock::now();
    const bool goes_on = viewer.frame(std::chrono::duration<double>(now - last).count());
    last = now;
    glfwSwapBuffers(window.handle());
    if (!goes_on) break;
    if (!shown) session.send(Request::simple(Request::Kind::Resume));
    shown = true;
    const double drawing = std::chrono::duration<double>(SteadyClock::now() - now).count();
    std::this_thread::sleep_until(now + std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(
                                            pace.turn(drawing, session.latest().status.overrun_count))));
  }

  session.finish();
  if (ResultFolder* results = session.results()) {
    results->writeReport(toJson(session.report()));
    results->writePicture(viewer.picture());
    session.log().info("results: " + results->reportFile());
  }
}

}  // namespace palpate::app

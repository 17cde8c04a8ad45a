#include "app/run/window.h"

#include <epoxy/gl.h>

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "app/panels/widgets.h"
#include "app/run/frame_pace.h"
#include "app/run/gl_window.h"
#include "app/run/recent_scenes.h"
#include "app/run/session_loader.h"
#include "app/run/viewer.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "realtime/loop/thread_setup.h"

namespace palpate::app {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double hidden_wait = 0.1;   // s, between looks at the loop while the window is minimised
constexpr double loading_turn = 0.1;  // s, between pictures of the progress: the set-up needs the cores

/// What comes after a session.
struct Next {
  bool quit = true;
  Options options;
};

/// The window with all that outlives a session.
class Shell {
 public:
  Shell(const Options& options, Log& log)
      : log_(log),
        loader_(log),  // before this thread takes its low priority
        priority_(setUpViewerThread()),
        window_(options, "Palpate"),
        ui_(window_.handle(), window_.interfaceScale()),
        recent_(RecentScenes::userFile()),
        renderer_name_(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) {
    log_.info("OpenGL: " + renderer_name_ + ", drawing at low priority: " + priority_);
  }

  /// The session, or null where the user would not wait. Throws what its making throws.
  std::unique_ptr<Session> load(const Options& options, const Scene& scene);
  Next show(Session& session);
  /// Says what is wrong until the user chooses; true: back to the scene before.
  bool askAfter(const std::string& problem);
  RecentScenes& recent() { return recent_; }

 private:
  bool beginPicture();
  void endPicture();

  Log& log_;
  SessionLoader loader_;
  std::string priority_;
  GlWindow window_;
  Interface ui_;
  PanelState panels_;
  RecentScenes recent_;
  std::string renderer_name_;
};

bool Shell::beginPicture() {
  window_.waitFor(loading_turn);
  if (!window_.visible()) return false;
  const CanvasSize size = window_.size();
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, size.pixelWidth(), size.pixelHeight());
  glClearColor(0.055F, 0.065F, 0.085F, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ui_.begin();
  const float s = ui_.theme().scale;
  const ImVec2 screen = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5F * screen.x, 0.5F * screen.y}, ImGuiCond_Always, {0.5F, 0.5F});
  ImGui::SetNextWindowSize({std::min(520 * s, screen.x - 20 * s), 0}, ImGuiCond_Always);
  ImGui::Begin("##loading", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  return true;
}

void Shell::endPicture() {
  ImGui::End();
  ui_.end();
  window_.show();
}

std::unique_ptr<Session> Shell::load(const Options& options, const Scene& scene) {
  window_.setTitle("Palpate - " + scene.name);
  loader_.begin(options, scene);
  while (loader_.busy()) {
    if (!beginPicture()) continue;
    const Theme& theme = ui_.theme();
    const SessionLoader::Progress progress = loader_.progress();
    ImGui::PushFont(theme.title);
    ImGui::TextUnformatted(scene.name.c_str());
    ImGui::PopFont();
    note(theme, "Getting the tissue ready: " + (progress.stage.empty() ? "reading" : progress.stage));
    ImGui::ProgressBar(static_cast<float>(progress.fraction), {-1, 0});
    note(theme, "The next start of this scene takes a moment: what is made now is kept.");
    endPicture();
    if (window_.closeAsked() || interrupted()) loader_.cancel();
  }
  if (window_.closeAsked()) {
    try {
      loader_.take();
    } catch (const std::exception&) {  // given up, or failed: nobody waits for it
    }
    return nullptr;
  }
  return loader_.take();
}

bool Shell::askAfter(const std::string& problem) {
  for (;;) {
    if (window_.closeAsked() || interrupted()) return false;
    if (!beginPicture()) continue;
    const Theme& theme = ui_.theme();
    ImGui::PushFont(theme.title);
    ImGui::TextUnformatted("This scene can't be used");
    ImGui::PopFont();
    note(theme, problem, colours::text);
    ImGui::Spacing();
    const bool back = button("Back to the scene before", 190 * theme.scale);
    ImGui::SameLine();
    const bool quit = button("Quit", 90 * theme.scale);
    endPicture();
    if (back || quit) return back;
  }
}

/// What a frame asks for, as options of the next session; throws InputError where it can't be read.
Options nextOptions(const Options& now, const ProgramRequests& wish) {
  Options next = now;
  next.record.clear();  // its file belongs to the session that ends
  next.replay.clear();
  next.out.clear();
  if (!wish.open_scene.empty()) {
    next.scene = wish.open_scene;
    next.tool_script.clear();
    next.tool_choice.reset();
  }
  if (!wish.open_script.empty()) next.tool_script = wish.open_script;
  if (wish.tool) next.tool_choice = wish.tool;
  return next;
}

Next Shell::show(Session& session) {
  Viewer viewer(session, window_, ui_, panels_);
  FramePace pace(isSoftwareRenderer(renderer_name_.c_str()));
  const std::vector<std::string> scenes = scenesToOpen(recent_);
  Next next;
  bool shown = false;
  auto last = SteadyClock::now();
  while (!session.finished() && !interrupted()) {
    if (!window_.visible() && !window_.closeAsked()) {
      window_.waitFor(hidden_wait);
      session.gather();
      continue;
    }
    window_.poll();
    const auto now = SteadyClock::now();
    ProgramRequests wish = viewer.frame(std::chrono::duration<double>(now - last).count(), scenes);
    last = now;
    window_.show();
    for (const std::string& dropped : window_.takeDropped())
      (std::filesystem::path(dropped).extension() == ".toml" ? wish.open_scene : wish.open_script) = dropped;
    if (wish.quit || window_.closeAsked()) break;
    if (!wish.open_scene.empty() || !wish.open_script.empty() || wish.tool) {
      try {  // what can be seen to be wrong leaves the present session as it is
        next.options = nextOptions(session.options(), wish);
        checkOptions(next.options);
        next.quit = false;
        break;
      } catch (const InputError& error) {
        log_.error(error.what());
      }
    }
    if (!shown) session.send(Request::simple(Request::Kind::Resume));
    shown = true;
    const double turn = pace.turn(std::chrono::duration<double>(SteadyClock::now() - now).count(),
                                  session.latest().status.overrun_count);
    std::this_thread::sleep_until(
        now + std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(turn)));
  }
  session.finish();
  if (ResultFolder* results = session.results()) {
    results->writeReport(toJson(session.report()));
    results->writePicture(viewer.picture());
    log_.info("results: " + results->reportFile());
  }
  return next;
}

}  // namespace

std::string runWindow(const Options& first, const Scene& first_scene, Log& log) {
  Shell shell(first, log);
  Options options = first;
  Scene scene = first_scene;
  std::optional<Options> before;  // that could be used
  for (;;) {
    std::unique_ptr<Session> session;
    try {
      session = shell.load(options, scene);
    } catch (const InputError& error) {
      if (!before) throw;
      log.error(error.what());
      if (!shell.askAfter(error.what())) return {};
      options = *before;
      scene = readScene(options);
      continue;
    }
    if (!session) return {};
    shell.recent().add(options.scene);
    before = options;
    const Next next = shell.show(*session);
    if (next.quit) return session->failure();
    options = next.options;
    scene = readScene(options);
  }
}

}  // namespace palpate::app

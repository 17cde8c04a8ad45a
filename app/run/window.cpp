#include "app/run/window.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <thread>
#include <utility>

#include "app/panels/widgets.h"
#include "app/run/frame_pace.h"
#include "app/run/gl_window.h"
#include "app/run/offscreen_run.h"
#include "app/run/recent_scenes.h"
#include "app/run/session_loader.h"
#include "app/run/viewer.h"
#include "base/input_error.h"
#include "base/interrupt.h"
#include "io/text_file.h"
#include "realtime/loop/thread_setup.h"

namespace palpate::app {

namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr double hidden_wait = 0.1;  // s, between looks at the loop while the window is minimised
// s, between pictures while nobody is there; a picture takes at most a quarter of it
constexpr double resting_turn = 0.15, paused_turn = 1;
constexpr double loading_turn = 0.1;  // s, between pictures of the progress: the set-up needs the cores

/// What comes after a session.
struct Next {
  bool quit = true;
  Options options;
};

/// The window with all that outlives a session.
class Shell {
 public:
  Shell(const Options& options, Log& log, const FrameWatch& watch)
      : log_(log),
        watch_(watch),
        loader_(log),  // before this thread takes its low priority
        priority_(setUpViewerThread()),
        window_(options, "Palpate"),
        ui_(window_.handle(), window_.interfaceScale()),
        recent_(RecentScenes::userFile()),
        renderer_name_(reinterpret_cast<const char*>(glGetString(GL_RENDERER))) {
    if (options.demo) {
      panels_.demo = true;
      panels_.panels_shown = false;
      window_.toggleFullScreen();
    }
    panels_.trainee = options.trainee_name;
    const std::string done = "done: ";
    log_.detail(
        "OpenGL: " + renderer_name_ +
        (priority_.starts_with(done) ? ", drawn at low priority" : ", not drawn at low priority: " + priority_));
  }

  /// The session, or null where the user would not wait. Throws what its making throws.
  std::unique_ptr<Session> load(const Options& options, const Scene& scene);
  std::unique_ptr<Viewer> viewerOf(Session& session);
  /// @param resume  with its first picture the session runs
  Next show(Session& session, Viewer& viewer, bool resume);
  /// Ends the session and keeps its results.
  void finish(Session& session, Viewer& viewer);
  /// Says over the picture, and in the log, what can't be used.
  void tell(const std::string& problem);
  bool ends() const { return window_.closeAsked() || interrupted(); }

 private:
  /// How often the lumps of a scene were shown, in the present session, too.
  int answersSeen(const Session& session, const std::string& scene_hash) {
    return answers_seen_[scene_hash] + (session.answersShown() && session.sceneHash() == scene_hash ? 1 : 0);
  }
  bool beginPicture();
  void endPicture();

  Log& log_;
  const FrameWatch& watch_;
  SessionLoader loader_;
  std::string priority_;
  GlWindow window_;
  Interface ui_;
  PanelState panels_;
  RecentScenes recent_;
  std::string renderer_name_;
  std::map<std::string, int> answers_seen_;  // by a scene's hash: how often its lumps were shown
};

/// A scene or a tool script, told by what is in it, a recording, or a curve, which is shown at once. Returns what is
/// wrong with anything else; empty: nothing.
std::string takeDropped(const std::string& file, UserActions& wish, PanelState& panels) {
  constexpr std::size_t most_bytes = 1 << 20;
  try {
    const std::string ending = std::filesystem::path(file).extension().string();
    if (ending == ".rec") {
      wish.push_back({UserAction::OpenRecording, 0, file});
      return {};
    }
    if (ending == ".csv") {
      panels.reference = readReferenceCurve(file);
      return {};
    }
    if (ending != ".toml")
      throw InputError({file}, "nothing that can be opened here",
                       "drop a scene or a tool script (.toml), a recording (.rec) or a force over depth (.csv)");
    const std::string text = readWholeFile(file, {}, most_bytes);
    const bool is_scene = text.find("[organ]") != std::string::npos;
    wish.push_back({is_scene ? UserAction::OpenScene : UserAction::OpenScript, 0, file});
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

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
  bool given_up = false;
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
    given_up |= button("Give up", 90 * theme.scale) || ends();
    endPicture();
    if (given_up) loader_.cancel();
  }
  if (!given_up) return loader_.take();
  try {
    loader_.take();
  } catch (const std::exception&) {  // given up, or failed: nobody waits for it
  }
  return nullptr;
}

std::unique_ptr<Viewer> Shell::viewerOf(Session& session) {
  recent_.add(session.options().scene);
  return std::make_unique<Viewer>(session, window_, ui_, panels_);
}

/// What a frame asks for, as options of the next session; throws InputError where it can't be read.
Options nextOptions(const Options& now, UserActions wish) {
  Options next = now;
  next.record.clear();  // its file belongs to the session that ends
  next.replay.clear();
  next.out.clear();
  std::stable_sort(wish.begin(), wish.end(), [](const UserAction& a, const UserAction& b) { return a.kind < b.kind; });
  for (const UserAction& action : wish) {
    const bool again = action.kind == UserAction::SearchAgain, scene = action.kind == UserAction::OpenScene,
               recording = action.kind == UserAction::OpenRecording;
    if (scene) next.scene = action.file;
    if (recording) next.replay = action.file;
    if (scene || again) next.tool_choice.reset();
    if (scene || again || recording) next.tool_script.clear(), next.answers = false;
    if (action.kind == UserAction::OpenScript) next.tool_script = action.file;
    if (action.kind == UserAction::UseProbe) next.tool_choice = action.tool;
  }
  return next;
}

void Shell::tell(const std::string& problem) {
  log_.error(problem);
  panels_.problem = problem;
}

Next Shell::show(Session& session, Viewer& viewer, bool resume) {
  window_.setTitle("Palpate - " + session.model().scene.name);
  FramePace pace(isSoftwareRenderer(renderer_name_.c_str()));
  const std::vector<std::string> scenes = scenesToOpen(recent_);
  Next next;
  auto last = SteadyClock::now();
  while (!session.finished() && !interrupted()) {
    if (!window_.visible() && !window_.closeAsked()) {
      window_.waitFor(hidden_wait);
      session.gather();
      continue;
    }
    window_.poll();
    const auto now = SteadyClock::now();
    UserActions wish = viewer.frame(std::chrono::duration<double>(now - last).count(), scenes);
    last = now;
    window_.show();
    if (watch_) watch_(session, viewer);
    for (const std::string& file : window_.takeDropped())
      if (const std::string problem = takeDropped(file, wish, panels_); !problem.empty()) tell(problem);
    wish = viewer.withConsent(wish);
    if (asks(wish, UserAction::Quit)) break;
    if (window_.closeAsked()) {
      if (!viewer.asksBeforeQuit()) break;
      window_.forgetClose();
    }
    if (!wish.empty()) {
      try {  // what can be seen to be wrong leaves the present session as it is
        next.options = nextOptions(session.options(), wish);
        checkOptions(next.options);
        next.options.answers_seen = answersSeen(session, sceneHash(next.options));
        next.quit = false;
        break;
      } catch (const InputError& error) {
        tell(error.what());
      }
    }
    if (std::exchange(resume, false)) session.send(Request::simple(Request::Kind::Resume));
    if (viewer.rests()) {  // until somebody comes
      const double drawn = std::chrono::duration<double>(SteadyClock::now() - now).count();
      window_.waitFor(std::max(session.latest().status.paused ? paused_turn : resting_turn, 4 * drawn) - drawn);
      continue;
    }
    const double turn = pace.turn(std::chrono::duration<double>(SteadyClock::now() - now).count(),
                                  session.latest().status.overrun_count);
    std::this_thread::sleep_until(
        now + std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(turn)));
  }
  return next;
}

void Shell::finish(Session& session, Viewer& viewer) {
  session.finish();
  answers_seen_[session.sceneHash()] += session.answersShown() ? 1 : 0;
  if (ResultFolder* results = session.results()) {
    session.attempt([&] {
      results->writeReport(toJson(session.report()));
      log_.info("results: " + results->reportFile());
    });
    Manifest manifest;
    session.attempt([&] {
      const Picture picture = viewer.picture();
      manifest.width = picture.width;
      manifest.height = picture.height;
      results->writePicture(picture);
      manifest.files.push_back(std::filesystem::path(results->pictureFile()).filename().string());
      manifest.picture_times_s.push_back(session.latest().force.time_s);
    });
    manifest.opengl = renderer_name_;
    session.attempt([&] { writeManifest(session, manifest); });
  }
}

}  // namespace

std::string runWindow(const Options& first, const Scene& first_scene, Log& log, const FrameWatch& watch) {
  Shell shell(first, log, watch);
  std::unique_ptr<Session> session = shell.load(first, first_scene);
  if (!session) return {};
  std::unique_ptr<Viewer> viewer = shell.viewerOf(*session);
  bool resume = true;
  for (;;) {
    const Next next = shell.show(*session, *viewer, resume);
    if (next.quit) {
      shell.finish(*session, *viewer);
      return session->failure();
    }
    // The present session waits meanwhile, and goes on where the next one can't be made.
    resume = !session->latest().status.paused;
    session->send(Request::simple(Request::Kind::Pause));
    std::unique_ptr<Session> made;
    try {
      made = shell.load(next.options, readScene(next.options));
    } catch (const std::exception& error) {
      shell.tell(error.what());
    }
    if (made || shell.ends()) shell.finish(*session, *viewer);
    if (shell.ends()) return session->failure();
    if (!made) continue;
    if (!session->failure().empty()) shell.tell(session->failure());
    resume = true;
    viewer.reset();
    session = std::move(made);
    viewer = shell.viewerOf(*session);
  }
}

}  // namespace palpate::app

#include "app/run/viewer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "app/panels/widgets.h"
#include "app/render/framebuffer.h"
#include "app/render/pick.h"
#include "app/render/solid_mesh.h"
#include "app/run/saved_files.h"
#include "app/trainer/score_page.h"

namespace palpate::app {

namespace {

constexpr double min_radius = 0.003, max_radius = 0.03, radius_step = 1e-3;  // m, of a probe that is chosen
constexpr double pick_pixels = 12;         // how near to the pointer an integration point must be
constexpr double most_look_seconds = 0.5;  // that one picture counts for, of what was looked at

/// Where on the skin at rest the point is that is now under the ray.
std::optional<Vec3> touchedAtRest(const TriangleSurface& rest, const std::vector<Vec3f>& positions, const Ray& ray) {
  const auto hit = pickSkin(rest, positions, ray);
  if (!hit) return {};
  const auto v = static_cast<std::size_t>(hit->vertex);
  return rest.vertices[v] + (hit->position - positions[v].cast<double>());
}

/// Whether the pointer, px, is on the probe as it is drawn, or nearly.
bool isOnProbe(const ToolShape& tool, const Pose& pose, const Camera& camera, const Eigen::Vector2d& pointer,
               const CanvasSize& size) {
  const auto at = [&](double z) {
    return camera.project(pose.toWorld({0, 0, z}), size.pixelWidth(), size.pixelHeight());
  };
  const Vec3 tip = at(0), end = at(static_cast<double>(toolHandleEnd(tool)));
  if (tip.z() <= 0 || end.z() <= 0) return false;
  const Eigen::Vector2d along = (end - tip).head<2>(), to = pointer - tip.head<2>();
  const double share = std::clamp(to.dot(along) / std::max(1e-9, along.squaredNorm()), 0.0, 1.0);
  const double radius = tool.radius / camera.pixelSize(pose.position, size.pixelHeight());
  return (to - share * along).norm() < std::max(pick_pixels * size.pixel_ratio, radius);
}

}  // namespace

Viewer::Viewer(Session& session, GlWindow& window, Interface& ui, PanelState& panels)
    : session_(session), window_(window), organ_(session.model()), ui_(ui), hand_(session.model()), panels_(panels) {
  const CanvasSize size = window.size();
  view_.camera = startCamera(session.model(), layoutFor(size.width, size.height, ui_.theme().scale, true), size);
  hand_.setMode(panels.glide ? HandMode::Glide : HandMode::Free);
}

Camera Viewer::shownCamera() const {
  const CanvasSize size = window_.size();
  return centredIn(layout(size), view_.camera, size);
}

const Snapshot& Viewer::shownSnapshot() const { return looked_at_ ? past_.at(*looked_at_) : session_.latest(); }

Layout Viewer::layout(const CanvasSize& size) const {
  const float overlays =
      (view_.colour_map != ColourMap::Tissue ? legend_room : 0) + (panels_.timeline_shown ? timeline_room : 0);
  return layoutFor(size.width, size.height, ui_.theme().scale, panels_.panels_shown, overlays);
}

void Viewer::send(const std::vector<Request>& requests) {
  for (const Request& request : requests) session_.send(request);
}

bool Viewer::byHand() const { return session_.driver() == ToolDriver::User && session_.options().device.empty(); }

bool Viewer::rests() const { return byHand() && nobody_s_ >= session_.options().idle_seconds; }

/// Back to the present, which goes on if it was the look back that held it.
void Viewer::leavePast() {
  looked_at_.reset();
  panels_.timeline_plays = false;
  if (std::exchange(paused_for_past_, false)) session_.send(Request::simple(Request::Kind::Resume));
}

/// What is left behind must not stay for those who come next.
void Viewer::passTime(bool somebody, double seconds) {
  nobody_s_ = somebody ? 0 : nobody_s_ + seconds;
  if (looked_at_ && nobody_s_ >= session_.options().idle_seconds && !panels_.timeline_plays) leavePast();
  session_.giveWay(panels_.demo && rests());
  if (attract_ && (somebody || !panels_.demo || !byHand())) {
    attract_.reset();
    if (session_.latest().status.paused) session_.send(Request::simple(Request::Kind::Resume));
  }
  if (!panels_.demo || !rests()) return;
  if (!attract_) startAttracting();
  if (session_.searching()) return;  // it would count as the trainee's
  const Snapshot& now = session_.latest();
  if (now.status.frozen) reset();
  send(attract_->next(nobody_s_ - session_.options().idle_seconds, hand_, now.goal_pose));
  if (attract_->rests() != now.status.paused)
    session_.send(Request::simple(attract_->rests() ? Request::Kind::Pause : Request::Kind::Resume));
}

/// As the scene begins: tissue at rest, its own materials, the first view.
void Viewer::startAttracting() {
  attract_.emplace(session_.model());
  panels_.help_shown = panels_.open_shown = false;
  panels_.at_stake.clear();
  panels_.problem.clear();
  session_.dismissNotice();
  session_.loadedSettings();
  reset();
  panels_.glide = true;
  hand_.setMode(HandMode::Glide);
  view_ = View{};
  const CanvasSize size = window_.size();
  view_.camera = startCamera(session_.model(), layout(size), size);
}

void Viewer::reset() {
  session_.send(Request::simple(Request::Kind::Reset));
  hand_.reset();
  grasp_.reset();
  view_.pulled_vertex = -1;
}

void Viewer::moveCamera(const Motion& motion, const CanvasSize& size) {
  const int height = size.pixelHeight();
  view_.camera.orbit(motion.orbit.x(), motion.orbit.y(), height);
  view_.camera.pan(motion.pan.x(), motion.pan.y(), height);
  if (motion.zoom != 0) view_.camera.zoom(motion.zoom);
}

void Viewer::carryOut(const UserAction& action, const Snapshot& snapshot, const CanvasSize& size) {
  using A = UserAction;
  using Kind = Request::Kind;
  const auto flip = [](bool& what) { what = !what; };
  const auto say = [&](Kind kind) { session_.say(Request::simple(kind)); };
  // clang-format off
  switch (action.kind) {
    case A::TogglePause: case A::SingleStep: case A::Reset: case A::ResetAll: case A::RestartScript: case A::Undo:
      return moveRun(action.kind, snapshot.status.paused);
    case A::DismissNotice: return session_.dismissNotice();
    case A::LookAt: return lookAt(action.value, snapshot);
    case A::LookNow: return leavePast();
    case A::Press: case A::Lift: case A::Grasp: case A::OpenJaws: case A::ToStart: case A::Upright:
      return moveByHand(action, snapshot);
    case A::SetGlide:
      panels_.glide = action.value != 0;
      return hand_.setMode(panels_.glide ? HandMode::Glide : HandMode::Free);
    case A::NextShape: case A::Larger: case A::Smaller: return chooseProbe(action.kind);
    case A::SetFriction: return session_.setFriction(action.value);
    case A::SetMaterial: return session_.setMaterial(static_cast<int>(action.value), action.material);
    case A::NextHardness: panels_.hardness = 1 + panels_.hardness % 3; return;
    case A::Mark: return session_.say(Request::mark(snapshot.toolPose().position, panels_.hardness));
    case A::Unmark: return say(Kind::Unmark);
    case A::Submit: return say(Kind::Submit);
    case A::FrameView: return frameOrgan(view_.camera, organ_, layout(size), size);
    case A::ShowColours:
      view_.colour_map = static_cast<ColourMap>(action.value);
      view_.colour_auto = true;
      return;
    case A::ToggleNodes: return flip(view_.show_nodes);
    case A::TogglePoints: return flip(view_.show_points);
    case A::ToggleGhost: return flip(view_.ghost);
    case A::ToggleSection:
      flip(view_.section.on);
      if (view_.section.on) faceCut(view_.section, view_.camera);
      return;
    case A::CutThroughTool:
      return cutThroughTool(view_.section, snapshot.toolPose(), view_.camera, organ_.centre(), organ_.radius());
    case A::TogglePanels: return flip(panels_.panels_shown);
    case A::ToggleEngineer: return flip(panels_.engineer);
    case A::ToggleHelp: return flip(panels_.help_shown);
    case A::ToggleTimeline:
      flip(panels_.timeline_shown);
      if (!panels_.timeline_shown) leavePast();
      return;
    case A::ToggleFullScreen: return window_.toggleFullScreen();
    case A::ToggleDemo:
      flip(panels_.demo);
      panels_.panels_shown = !panels_.demo;
      panels_.timeline_shown = false;
      leavePast();
      if (panels_.demo != window_.fullScreen()) window_.toggleFullScreen();
      return;
    case A::Close: return closeTopmost();
    case A::AskForFile:
      panels_.open_shown = true;
      panels_.open_kind = static_cast<OpenKind>(action.value);
      return panels_.path.clear();
    case A::LayCurve: case A::SavePicture: case A::SaveForces: case A::SavePresses: case A::SaveState:
    case A::SaveRecording: return useFile(action);
    case A::ClearPresses: return session_.clearPresses();
    case A::UseProbe:
      if (!session_.searching() && std::exchange(panels_.tool_edited, false))
        leaving_.push_back({.kind = A::UseProbe, .tool = panels_.tool});
      return;
    case A::OpenScene: case A::OpenScript: case A::OpenRecording: case A::SearchAgain: case A::Quit: case A::Leave:
      return leaving_.push_back(action);
  }
  // clang-format on
}

/// What moves the run shows the present again.
void Viewer::moveRun(UserAction::Kind kind, bool paused) {
  using A = UserAction;
  const auto ask = [&](Request::Kind what) { session_.send(Request::simple(what)); };
  if (kind == A::SingleStep) paused_for_past_ = false;
  leavePast();
  if (kind == A::TogglePause) return ask(paused ? Request::Kind::Resume : Request::Kind::Pause);
  if (kind == A::SingleStep) {
    if (!paused) ask(Request::Kind::Pause);
    return ask(Request::Kind::SingleStep);
  }
  session_.dismissNotice();
  if (kind == A::Undo) return ask(Request::Kind::Undo);
  reset();
  if (kind == A::ResetAll) session_.loadedSettings();
  if (kind == A::RestartScript && paused) ask(Request::Kind::Resume);
}

/// While a script moves the probe, or the past is seen, the hand rests.
void Viewer::moveByHand(const UserAction& action, const Snapshot& snapshot) {
  using A = UserAction;
  if (session_.driver() != ToolDriver::User || looked_at_) return;
  const double speed = 1e-3 * panels_.tool_speed_mm_s;
  grasp_.reset();
  if (action.kind == A::Press) send(hand_.press(1e-3 * panels_.press_mm, speed, snapshot.goal_pose));
  if (action.kind == A::Lift) send(hand_.lift(speed, snapshot.goal_pose));
  if (action.kind == A::ToStart) send(hand_.toStart());
  if (action.kind == A::Upright) send(hand_.upright());
  if (action.kind == A::Grasp && hand_.hasJaws()) grasp_.emplace();
  if (action.kind == A::OpenJaws && hand_.hasJaws()) send({hand_.open(action.value)});
}

/// As in the panel, by keys.
void Viewer::chooseProbe(UserAction::Kind next) {
  if (session_.searching()) return;  // with the scene's probe
  const ToolShape& tool = session_.model().scene.tools[0].shape;
  ToolChoice& chosen = panels_.tool;
  if (!panels_.tool_edited) chosen = {tool.kind, tool.radius};
  panels_.tool_edited = panels_.panels_shown = true;
  const auto kinds = static_cast<int>(std::size(toolTypes()));
  if (next == UserAction::NextShape) chosen.kind = static_cast<ToolKind>((static_cast<int>(chosen.kind) + 1) % kinds);
  const double wider = next == UserAction::Larger ? radius_step : next == UserAction::Smaller ? -radius_step : 0;
  chosen.radius = std::clamp(chosen.radius + wider, min_radius, max_radius);
}

void Viewer::closeTopmost() {
  if (menuOpen())
    closeMenus();
  else if (!panels_.problem.empty())
    panels_.problem.clear();
  else if (panels_.help_shown)
    panels_.help_shown = false;
  else if (panels_.open_shown || !panels_.at_stake.empty())
    panels_.open_shown = false, panels_.at_stake.clear();
}

/// The run waits meanwhile.
void Viewer::lookAt(double run_s, const Snapshot& snapshot) {
  if (past_.empty()) return;
  if (!snapshot.status.paused && !looked_at_) {
    session_.send(Request::simple(Request::Kind::Pause));
    paused_for_past_ = true;
  }
  looked_at_ = run_s;
}

void Viewer::moveTool(const Motion& motion, const Camera& camera, const Snapshot& snapshot, const Input& input,
                      const CanvasSize& size, double seconds) {
  if (session_.driver() != ToolDriver::User) {
    hand_.reset();
    hand_.moveTo(snapshot.toolPose());  // so that the hand takes over where the script ends
    return;
  }
  if (std::exchange(undo_count_, snapshot.status.undo_count) != snapshot.status.undo_count) {
    hand_.moveTo(snapshot.hand_pose);  // where the tool was then
    grasp_.reset();
    view_.pulled_vertex = -1;
  }
  const bool by_itself = !motion.glide && motion.tool_keys.isZero(0) && motion.turn_keys.isZero(0) &&
                         motion.jaws_keys == 0 && motion.push_tool_notches == 0 && drag() != Drag::MoveTool;
  if (!by_itself) grasp_.reset();
  if (grasp_) send(grasp_->next(snapshot, hand_));
  if (grasp_ && grasp_->done()) grasp_.reset();
  std::optional<Vec3> touched;
  if (motion.glide)
    touched = touchedAtRest(session_.model().skin.surface, organ_.skinPositions(),
                            camera.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight()));
  send(hand_.apply(motion, touched, camera, size.pixelHeight(), 1e-3 * panels_.tool_speed_mm_s, seconds,
                   snapshot.goal_pose));
}

void Viewer::pull(const Motion& motion, const Camera& camera, const Eigen::Vector2d& mouse, const CanvasSize& size) {
  const Ray ray = camera.rayThrough(mouse.x(), mouse.y(), size.pixelWidth(), size.pixelHeight());
  if (motion.pull_begin && session_.driver() == ToolDriver::User) {
    if (const auto hit = pickSkin(session_.model().skin.surface, organ_.skinPositions(), ray)) {
      view_.pulled_vertex = hit->vertex;
      view_.pull_target = hit->position;
    }
  }
  if (view_.pulled_vertex < 0) return;
  if (!motion.pulling) {
    view_.pulled_vertex = -1;
    session_.send(Request::simple(Request::Kind::ReleasePull));
    return;
  }
  // The target stays in the plane through the first hit that faces the viewer.
  const double depth = (view_.pull_target - ray.origin).dot(camera.forward());
  const Vec3 target = ray.origin + depth / ray.direction.dot(camera.forward()) * ray.direction;
  if (motion.pull_begin || target != view_.pull_target) {
    view_.pull_target = target;
    session_.send(Request::pull(view_.pulled_vertex, target));
  }
}

/// Once the answers are in, the lumps are shown and the score sheet is written.
void Viewer::showAnswers() {
  if (!session_.revealed() || answers_shown_) return;
  answers_shown_ = view_.ghost = true;
  const SheetHead head = session_.sheetHead(panels_.trainee);
  try {
    session_.log().info(
        "score: " +
        SavedFiles(session_.options().scene)
            .score(*session_.task(), head, scorePage(ui_.theme(), session_.model(), organ_, *session_.task(), head)));
  } catch (const std::exception& error) {
    sheet_lost_ = true;
    session_.log().error(error.what());
    panels_.problem = error.what();
  }
}

/// What can't be written or read is said; the run goes on.
void Viewer::useFile(const UserAction& action) {
  try {
    const SavedFiles files(session_.options().scene);
    const auto saved = [&](const std::string& file) { session_.log().info("saved: " + file); };
    if (action.kind == UserAction::SavePicture) saved(files.picture(picture()));
    if (action.kind == UserAction::SaveForces) saved(files.forces(session_.samples()));
    if (action.kind == UserAction::SavePresses) saved(files.presses(session_.presses()));
    if (action.kind == UserAction::SaveRecording) saved(files.recording(session_.recordingSoFar()));
    if (action.kind == UserAction::LayCurve) panels_.reference = readReferenceCurve(action.file);
    if (action.kind == UserAction::SaveState)
      saved(files.state(modelOf(session_.latest(), session_.model()), session_.latest()));
  } catch (const std::exception& error) {
    session_.log().error(error.what());
    panels_.problem = error.what();
  }
}

UserActions Viewer::frame(double seconds, const std::vector<std::string>& scenes) {
  const CanvasSize size = window_.size();
  constexpr double share = 0.05;  // of the newest frame in the mean that is shown
  frame_seconds_ = frame_seconds_ == 0 ? seconds : frame_seconds_ + share * (seconds - frame_seconds_);
  session_.gather();
  showAnswers();
  if (answers_shown_ && panels_.at_stake.empty()) answers_seconds_ += std::min(seconds, most_look_seconds);
  const Snapshot& snapshot = session_.latest();
  const KeyPresses presses = window_.takePressed();
  ui_.hold(presses.taps());
  ui_.begin();

  Input input = inputFromImGui(presses);
  passTime(input.anything, seconds);
  input.keys_taken |= panels_.open_shown;  // also while its text field does not yet have the keyboard
  input.mouse *= size.pixel_ratio;
  input.mouse_delta *= size.pixel_ratio;
  const Camera before = centredIn(layout(size), view_.camera, size);
  input.free_probe = !panels_.glide;
  if (controls_.drag() == Drag::None && (input.left || input.right) && byHand())
    input.on_probe = isOnProbe(session_.model().scene.tools[0].shape, snapshot.toolPose(), before, input.mouse, size);
  if (panels_.glide && controls_.drag() == Drag::None && (input.left || input.right))
    input.on_skin = pickSkin(session_.model().skin.surface, organ_.skinPositions(),
                             before.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight()))
                        .has_value();
  const bool something_open = menuOpen() || panels_.help_shown || panels_.open_shown || !panels_.at_stake.empty() ||
                              panels_.demo || !panels_.problem.empty();
  const Motion motion = controls_.read(input);
  moveCamera(motion, size);
  leaving_.clear();
  UserActions later;  // a picture is drawn in a frame of its own, once this one is
  for (const UserAction& action : askedByKeys(input, something_open, panels_.demo))
    if (action.kind == UserAction::SavePicture)
      later.push_back(action);
    else
      carryOut(action, snapshot, size);
  const Camera shown = centredIn(layout(size), view_.camera, size);
  past_.add(snapshot);
  if (!looked_at_) {
    moveTool(motion, shown, snapshot, input, size, seconds);
    pull(motion, shown, input.mouse, size);
  }
  if (motion.pick_point && !panels_.demo) {
    const Ray ray = shown.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight());
    view_.picked_point = pickPoint(modelOf(snapshot, session_.model()), snapshot, ray,
                                   pick_pixels * shown.pixelSize(shown.target, size.pixelHeight()));
  }

  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  Shown& more = shown_;
  more.frames_per_second = frame_seconds_ > 0 ? 1 / frame_seconds_ : 0;
  more.scenes = scenes;
  more.attracts = attracts();
  more.hand_on_skin = hand_.onSkin();
  more.widest_jaws_m = hand_.hasJaws() ? hand_.widest() : 0;
  more.hand_presses = hand_.onSkin() && hand_.depth() > 0;
  more.timeline = TimelineView{past_.begin_s(), snapshot.force.time_s, looked_at_.value_or(snapshot.force.time_s),
                               looked_at_.has_value()};
  const Snapshot& drawn = shownSnapshot();
  if (looked_at_ && (!past_forces_ || past_forces_->lastTime() != drawn.force.time_s))
    past_forces_ = session_.forcesUntil(drawn);
  more.past_forces = looked_at_ ? &*past_forces_ : nullptr;
  const UserActions clicked = drawComposition(organ_, ui_, session_, drawn, view_, panels_, layout(size), size, more);
  later.insert(later.end(), clicked.begin(), clicked.end());
  for (const UserAction& action : later) carryOut(action, snapshot, size);
  return leaving_;
}

std::string Viewer::atStake() const {
  constexpr double look_seconds = 5;  // that answers are taken to have been looked at
  if (session_.searching() && session_.task()->begun() && session_.driver() != ToolDriver::Replay)
    return "A search is under way: what was felt and marked would be lost.";
  if (sheet_lost_) return "The score sheet could not be written, and would be lost.";
  if (answers_shown_ && answers_seconds_ < look_seconds)
    return "The answers were shown just now, and not looked at yet.";
  return {};
}

bool Viewer::asksBeforeQuit() {
  const std::string lost = atStake();
  if (!lost.empty()) panels_.at_stake = lost;
  return !lost.empty();
}

UserActions Viewer::withConsent(const UserActions& wish) {
  if (panels_.at_stake.empty()) asked_.clear();  // the user stays
  if (asks(wish, UserAction::SearchAgain)) {
    panels_.at_stake.clear();
    return wish;
  }
  if (asks(wish, UserAction::Leave)) {
    panels_.at_stake.clear();
    return asked_.empty() ? UserActions{{UserAction::Quit}} : std::exchange(asked_, {});
  }
  if (wish.empty() || !asksBeforeQuit()) return wish;
  asked_ = wish;
  return {};
}

Picture Viewer::picture() {
  const CanvasSize size = window_.size();
  const Framebuffer framebuffer(size.pixelWidth(), size.pixelHeight());
  framebuffer.bind();
  ui_.begin();
  drawComposition(organ_, ui_, session_, shownSnapshot(), view_, panels_, layout(size), size, shown_);
  return framebuffer.read();
}

}  // namespace palpate::app

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

constexpr double min_radius = 0.003, max_radius = 0.03;  // m, of a probe that is chosen
constexpr double pick_pixels = 12;                       // how near to the pointer an integration point must be
constexpr double most_look_seconds = 0.5;                // that one picture counts for, of what was looked at

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

void Viewer::applyView(const Actions& actions, const CanvasSize& size) {
  const int height = size.pixelHeight();
  view_.camera.orbit(actions.orbit.x(), actions.orbit.y(), height);
  view_.camera.pan(actions.pan.x(), actions.pan.y(), height);
  if (actions.zoom != 0) view_.camera.zoom(actions.zoom);
  if (actions.colour_map >= 0) {
    view_.colour_map = static_cast<ColourMap>(actions.colour_map);
    view_.colour_auto = true;
  }
  if (actions.toggle_nodes) view_.show_nodes = !view_.show_nodes;
  if (actions.toggle_points) view_.show_points = !view_.show_points;
  if (actions.toggle_panels) panels_.panels_shown = !panels_.panels_shown;
  if (actions.toggle_help) panels_.help_shown = !panels_.help_shown;
  if (actions.close) {
    if (menuOpen())
      closeMenus();
    else if (!panels_.problem.empty())
      panels_.problem.clear();
    else if (panels_.help_shown)
      panels_.help_shown = false;
    else if (panels_.open_shown || !panels_.at_stake.empty())
      panels_.open_shown = false, panels_.at_stake.clear();
  }
  if (actions.open_scene) panels_.open_shown = true, panels_.open_kind = OpenKind::Scene, panels_.path.clear();
  if (actions.toggle_timeline) {
    panels_.timeline_shown = !panels_.timeline_shown;
    if (!panels_.timeline_shown) leavePast();
  }
  if (actions.toggle_full_screen) window_.toggleFullScreen();
  if (actions.toggle_ghost) view_.ghost = !view_.ghost;
  if (actions.toggle_section) {
    view_.section.on = !view_.section.on;
    if (view_.section.on) faceCut(view_.section, view_.camera);
  }
  if (actions.frame_view) frameOrgan(view_.camera, organ_, layout(size), size);
}

void Viewer::applyRun(const Actions& actions, const Snapshot& snapshot) {
  using Kind = Request::Kind;
  // What moves the run shows the present again.
  if (actions.single_step > 0) paused_for_past_ = false;
  if (actions.toggle_pause || actions.single_step > 0 || actions.reset || actions.undo > 0) leavePast();
  if (actions.toggle_pause) session_.send(Request::simple(snapshot.status.paused ? Kind::Resume : Kind::Pause));
  if (actions.single_step > 0 && !snapshot.status.paused) session_.send(Request::simple(Kind::Pause));
  for (int k = 0; k < actions.single_step; ++k) session_.send(Request::simple(Kind::SingleStep));
  if (actions.reset) reset();
  for (int k = 0; k < actions.undo; ++k) session_.send(Request::simple(Kind::Undo));
}

void Viewer::applyTool(const Actions& actions, const Camera& camera, const Snapshot& snapshot, const Input& input,
                       const CanvasSize& size, double seconds) {
  if (session_.driver() != ToolDriver::User) {
    hand_.reset();
    hand_.moveTo(snapshot.tool_pose);  // so that the hand takes over where the script ends
    return;
  }
  if (std::exchange(undo_count_, snapshot.status.undo_count) != snapshot.status.undo_count) {
    hand_.moveTo(snapshot.hand_pose);  // where the tool was then
    grasp_.reset();
    view_.pulled_vertex = -1;
  }
  const bool by_itself = !actions.glide && actions.tool_keys.isZero(0) && actions.turn_keys.isZero(0) &&
                         actions.jaws_keys == 0 && actions.push_tool_notches == 0 && drag() != Drag::MoveTool;
  if (!by_itself) grasp_.reset();
  if (grasp_) send(grasp_->next(snapshot, hand_));
  if (grasp_ && grasp_->done()) grasp_.reset();
  std::optional<Vec3> touched;
  if (actions.glide)
    touched = touchedAtRest(session_.model().skin.surface, organ_.skinPositions(),
                            camera.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight()));
  send(hand_.apply(actions, touched, camera, size.pixelHeight(), 1e-3 * panels_.tool_speed_mm_s, seconds,
                   snapshot.goal_pose));
}

void Viewer::applyPull(const Actions& actions, const Camera& camera, const Eigen::Vector2d& mouse,
                       const CanvasSize& size) {
  const Ray ray = camera.rayThrough(mouse.x(), mouse.y(), size.pixelWidth(), size.pixelHeight());
  if (actions.pull_begin && session_.driver() == ToolDriver::User) {
    if (const auto hit = pickSkin(session_.model().skin.surface, organ_.skinPositions(), ray)) {
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
  actions.single_step = requests.single_step ? 1 : 0;
  actions.reset = requests.reset || requests.restart_script || requests.reset_all;
  actions.undo = requests.undo ? 1 : 0;
  applyRun(actions, snapshot);
  if (requests.reset_all) session_.loadedSettings();
  if (requests.dismiss_notice || actions.undo > 0 || actions.reset) session_.dismissNotice();
  if (requests.restart_script && snapshot.status.paused) session_.send(Request::simple(Request::Kind::Resume));
  if (requests.frame_view) frameOrgan(view_.camera, organ_, layout(size), size);
  if (requests.glide) hand_.setMode(*requests.glide ? HandMode::Glide : HandMode::Free);
  if (requests.section_through_tool)
    cutThroughTool(view_.section, snapshot.tool_pose, view_.camera, organ_.centre(), organ_.radius());
  if (requests.section_faces) faceCut(view_.section, view_.camera);
  if (requests.tool_to_start) send(hand_.toStart());
  if (requests.upright) send(hand_.upright());
  const double speed = 1e-3 * panels_.tool_speed_mm_s;
  if (session_.driver() == ToolDriver::User && !looked_at_) {
    if (requests.press) send(hand_.press(*requests.press, speed, snapshot.goal_pose));
    if (requests.press || requests.lift || requests.opening || requests.tool_to_start) grasp_.reset();
    if (requests.grasp && hand_.hasJaws()) grasp_.emplace();
    if (requests.opening && hand_.hasJaws()) send({hand_.open(*requests.opening)});
    if (requests.lift) send(hand_.lift(speed, snapshot.goal_pose));
  }
  if (requests.friction) session_.setFriction(*requests.friction);
  if (requests.material >= 0) session_.setMaterial(requests.material, requests.changed);
  if (requests.full_screen) window_.toggleFullScreen();
  if (requests.demo) {
    panels_.demo = !panels_.demo;
    panels_.panels_shown = !panels_.demo;
    panels_.timeline_shown = false;
    leavePast();
    if (panels_.demo != window_.fullScreen()) window_.toggleFullScreen();
  }
  if (requests.mark) session_.say(Request::mark(snapshot.tool_pose.position, panels_.hardness));
  if (requests.unmark) session_.say(Request::simple(Request::Kind::Unmark));
  if (requests.submit) session_.say(Request::simple(Request::Kind::Submit));
  if (requests.look_at_s && !past_.empty()) {
    if (!snapshot.status.paused && !looked_at_) {
      session_.send(Request::simple(Request::Kind::Pause));
      paused_for_past_ = true;
    }
    looked_at_ = *requests.look_at_s;
  }
  if (requests.look_now) leavePast();
  applyFiles(requests);
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

/// What can't be written is said in the log; the run goes on.
void Viewer::applyFiles(const PanelRequests& requests) {
  try {
    Log& log = session_.log();
    const SavedFiles files(session_.options().scene);
    if (requests.save_picture) log.info("saved: " + files.picture(picture()));
    if (requests.save_forces) log.info("saved: " + files.forces(session_.samples()));
    if (requests.save_presses) log.info("saved: " + files.presses(session_.presses()));
    if (requests.save_recording) log.info("saved: " + files.recording(session_.recordingSoFar()));
    if (!requests.open_curve.empty()) panels_.reference = readReferenceCurve(requests.open_curve);
    if (requests.save_state)
      log.info("saved: " + files.state(modelOf(session_.latest(), session_.model()), session_.latest()));
  } catch (const std::exception& error) {
    session_.log().error(error.what());
    panels_.problem = error.what();
  }
  if (requests.clear_presses) session_.clearPresses();
}

/// What is chosen in the panels, chosen by keys.
void Viewer::applyChoices(const Actions& actions, PanelRequests& requests) {
  if (actions.toggle_engineer) panels_.engineer = !panels_.engineer;
  if (actions.next_hardness > 0) panels_.hardness = 1 + (panels_.hardness - 1 + actions.next_hardness) % 3;
  if (session_.searching()) return;  // with the scene's probe
  if (actions.next_shape > 0 || actions.radius_steps != 0) {
    const ToolShape& tool = session_.model().scene.tool;
    if (!panels_.tool_edited) panels_.tool = {tool.kind, tool.radius};
    const auto kinds = static_cast<int>(std::size(toolTypes()));
    panels_.tool.kind = static_cast<ToolKind>((static_cast<int>(panels_.tool.kind) + actions.next_shape) % kinds);
    panels_.tool.radius = std::clamp(panels_.tool.radius + 1e-3 * actions.radius_steps, min_radius, max_radius);
    panels_.tool_edited = panels_.panels_shown = true;
  }
  if (actions.use_probe && std::exchange(panels_.tool_edited, false)) requests.tool = panels_.tool;
}

ProgramRequests Viewer::frame(double seconds, const std::vector<std::string>& scenes) {
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
    input.on_probe = isOnProbe(session_.model().scene.tool, snapshot.tool_pose, before, input.mouse, size);
  if (panels_.glide && controls_.drag() == Drag::None && (input.left || input.right))
    input.on_skin = pickSkin(session_.model().skin.surface, organ_.skinPositions(),
                             before.rayThrough(input.mouse.x(), input.mouse.y(), size.pixelWidth(), size.pixelHeight()))
                        .has_value();
  const bool something_open = menuOpen() || panels_.help_shown || panels_.open_shown || !panels_.at_stake.empty() ||
                              panels_.demo || !panels_.problem.empty();
  Actions actions = controls_.read(input, something_open);
  if (panels_.demo) actions = lockedForDemo(actions);
  applyView(actions, size);
  applyRun(actions, snapshot);
  const Camera shown = centredIn(layout(size), view_.camera, size);
  past_.add(snapshot);
  if (!looked_at_) {
    applyTool(actions, shown, snapshot, input, size, seconds);
    applyPull(actions, shown, input.mouse, size);
  }
  if (actions.pick_point) {
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
  PanelRequests requests = drawComposition(organ_, ui_, session_, drawn, view_, panels_, layout(size), size, more);
  requests.save_picture |= actions.save_picture;
  requests.save_forces |= actions.save_forces;
  requests.demo |= actions.toggle_demo;
  requests.mark |= actions.mark;
  requests.lift |= actions.lift;
  if (actions.press) requests.press = 1e-3 * panels_.press_mm;
  applyChoices(actions, requests);
  applyRequests(requests, snapshot, size);
  ProgramRequests program;
  program.quit = (actions.quit || requests.quit) && !asksBeforeQuit();
  program.agreed = requests.quit_now;
  program.open_scene = requests.search_again ? session_.options().scene : requests.open_scene;
  program.agreed |= requests.search_again;
  program.open_script = requests.open_script;
  program.open_recording = requests.open_recording;
  program.tool = requests.tool;
  return program;
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

ProgramRequests Viewer::withConsent(const ProgramRequests& wish) {
  if (panels_.at_stake.empty()) asked_.reset();  // the user stays
  if (wish.agreed) {
    panels_.at_stake.clear();
    if (wish.leaves()) return wish;
    if (asked_) return *std::exchange(asked_, {});
    ProgramRequests quit;
    quit.quit = true;
    return quit;
  }
  if (!wish.leaves() || !asksBeforeQuit()) return wish;
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

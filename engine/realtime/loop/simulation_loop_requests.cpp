// What others ask of the loop, taken between two ticks: by viewers, hands, devices and recordings.

#include "realtime/loop/simulation_loop.h"

namespace palpate {
namespace {

LogEvent::Kind eventOf(Request::Kind setting) {
  switch (setting) {
    case Request::Kind::SetFriction:
      return LogEvent::Kind::FrictionSet;
    case Request::Kind::SetMaterial:
      return LogEvent::Kind::MaterialSet;
    case Request::Kind::SetGravity:
      return LogEvent::Kind::GravitySet;
    case Request::Kind::SetForce:
      return LogEvent::Kind::ForceSet;
    case Request::Kind::MoveRegion:
      return LogEvent::Kind::RegionMoved;
    default:
      return LogEvent::Kind::Pinned;
  }
}

}  // namespace

void SimulationLoop::takeRequests() {
  // What comes in meanwhile waits for the next tick: a producer without a pause must not hold this one up.
  Request request;
  for (std::size_t waiting = channels_.commands.size(); waiting > 0; --waiting) {
    if (channels_.commands.pop(request)) apply(request, false);
  }
}

void SimulationLoop::takeFurtherHands() {
  const bool driven = track_.drives(run_.tick);
  ToolHands& hands = channels_.tool_hands;
  for (int k = 0; k < model_.tools.toolCount(); ++k) {
    if (k > 0)
      if (HandSlot& hand = hands.further[static_cast<std::size_t>(k - 1)]; hand.hasNews()) {
        const Request move = Request::moveHand(k, hand.latest().pose);
        if (!driven) further_.take(move, command_);
      }
    const Request open = Request::setOpening(k, hands.takeOpening(k));
    if (!driven) further_.take(open, command_);
  }
}

void SimulationLoop::takeHand() {
  if (model_.tools.several()) takeFurtherHands();
  if (!channels_.hand.hasNews()) return;
  const HandPose& hand = channels_.hand.latest();
  if (track_.drives(run_.tick)) return;
  run_.pose_sequence = hand.sequence;
  moveTool(Request::moveTool(hand.pose), true);
}

void SimulationLoop::apply(const Request& request, bool from_track) {
  using Kind = Request::Kind;
  switch (request.kind) {
    case Kind::Pause:
      if (!run_.paused) reporter_.logEvent(LogEvent::Kind::Paused, run_);
      run_.paused = true;
      return;
    case Kind::Resume:
      if (run_.paused && !(run_.starts_paused && run_.tick == 0)) reporter_.logEvent(LogEvent::Kind::Resumed, run_);
      run_.paused = false;
      run_.single_steps = 0;
      return;
    case Kind::SingleStep:
      if (run_.paused) ++run_.single_steps;
      return;
    case Kind::Quit:
      run_.stop = true;
      return;
    case Kind::Reset:
    case Kind::Restart:
      return reset(request.kind, from_track);
    case Kind::Mark:
    case Kind::Unmark:
    case Kind::Submit:
      return say(request, from_track);
    default:
      break;
  }
  // What is left moves the physics: while the track lasts, it alone may.
  if (!from_track && track_.drives(run_.tick)) return;
  switch (request.kind) {
    case Kind::Undo:
      return undo();
    case Kind::MoveTool:
    case Kind::ThenMoveTool:
      return moveTool(request, from_track);
    case Kind::Steer:
      return steer(request);
    case Kind::Pull:
      return pull(request.index, request.point);
    case Kind::ReleasePull:
      command_.pull_vertex = -1;
      command_.pull_target.setZero();
      return;
    case Kind::MoveHand:
    case Kind::SetOpening:
      return further_.take(request, command_);
    case Kind::GoToPlace:
      return goToPlace(request.place);
    case Kind::SetFriction:
    case Kind::SetMaterial:
    case Kind::SetGravity:
    case Kind::SetForce:
    case Kind::Pin:
    case Kind::Unpin:
    case Kind::MoveRegion:
      return change(request);
    default:
      return;
  }
}

void SimulationLoop::moveTool(const Request& request, bool from_track) {
  Pose target = request.pose;
  if (!target.isSound()) return;
  if (from_track) {  // exactly, and at once
    command_.tools[0].pose = target;
    track_.goal().jumpTo(target);
    return;
  }
  target.orientation.normalize();
  if (request.kind == Request::Kind::ThenMoveTool)
    track_.goal().thenMoveTo(target, request.value);
  else
    track_.goal().moveTo(target, request.value);
}

void SimulationLoop::goToPlace(const PlaceIndex& index) {
  if (follower_ == nullptr || !follower_->goTo(index, channels_.quit)) return;
  recorder_.add(run_.tick, Request::goToPlace(index));
  goOnAtPlace(true);
}

void SimulationLoop::steer(const Request& request) {
  if (request.pose.position.allFinite() && request.point.allFinite())
    track_.goal().steer(request.pose.position, request.point, request.value);
}

void SimulationLoop::pull(int skin_vertex, const Vec3& target) {
  if (skin_vertex < 0 || skin_vertex >= static_cast<int>(model_.skin.surface.vertices.size())) return;
  if (!target.allFinite()) return;
  command_.pull_vertex = skin_vertex;
  command_.pull_target = target;
}

void SimulationLoop::change(const Request& setting) {
  const LiveSettings::Answer answer = settings_.apply(setting);
  if (answer.outcome == LiveSettings::Outcome::Refused) {
    reporter_.logEvent(LogEvent::Kind::MaterialRefused, run_, setting.index, answer.excess);
  }
  if (answer.outcome != LiveSettings::Outcome::Changed) return;
  recorder_.add(run_.tick, setting);
  const LogEvent::Kind kind = eventOf(setting.kind);
  const bool load = kind != LogEvent::Kind::FrictionSet && kind != LogEvent::Kind::MaterialSet;
  if (load && !answer.acts) return;  // one that goes on may change each tick
  reporter_.logEvent(kind, run_, setting.index, load ? *answer.acts : setting.value, setting.point);
}

void SimulationLoop::say(const Request& said, bool from_track) {
  using Kind = LogEvent::Kind;
  recorder_.add(run_.tick, said);
  if (said.kind == Request::Kind::Mark) return reporter_.logEvent(Kind::Marked, run_, said.index, 0, said.point);
  if (said.kind == Request::Kind::Unmark) return reporter_.logEvent(Kind::Unmarked, run_);
  reporter_.logEvent(Kind::Submitted, run_, from_track ? 1 : -1);
}

void SimulationLoop::undo() {
  const std::int64_t tick = physics_.state().tick;
  const State* past = history_.before(tick);
  if (past == nullptr) return reporter_.logEvent(LogEvent::Kind::Undone, run_);
  goBackTo(*past);
  run_.frozen = false;
  ++run_.undo_count;
  reporter_.reset();
  command_ = restCommand(model_);
  command_.tools = posturesOf(*past);
  run_.hand = run_.goal = command_.tools[0].pose;
  track_.goal().jumpTo(run_.goal);
  recorder_.addJump(run_.tick, Request::Kind::Undo, command_);
  const double seconds = static_cast<double>(tick - past->tick) / model_.scene.dynamics.rate_hz;
  reporter_.logEvent(LogEvent::Kind::Undone, run_, -1, seconds);
}

void SimulationLoop::reset(Request::Kind kind, bool from_track) {
  const bool over = !from_track && track_.startOver(run_.tick);
  if (over || (!from_track && track_.drives(run_.tick))) kind = Request::Kind::Restart;  // an endless motion, too
  physics_.reset();
  goOnAtPlace(false);
  run_.reset_tick = run_.tick;
  history_.clear();
  if (kind == Request::Kind::Reset) beGentle();
  run_.frozen = false;
  reporter_.reset();
  track_.reset();
  if (device_ != nullptr) device_->restart();
  command_ = restCommand(model_);
  run_.hand = run_.goal = model_.tools.first().start.pose;
  further_.restart(run_.tick);
  recorder_.addJump(run_.tick, kind, command_);
  reporter_.logEvent(LogEvent::Kind::Reset, run_, over ? 1 : -1);
  if (!over || keeps_settings_) return;
  for (const Request& setting : settings_.loaded()) change(setting);
}

}  // namespace palpate

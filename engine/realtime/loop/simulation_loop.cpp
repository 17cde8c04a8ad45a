#include "realtime/loop/simulation_loop.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/trust.h"

namespace palpate {
namespace {

constexpr std::size_t kCommandCapacity = 1024;
constexpr std::size_t kLogCapacity = 1024;

// The viewer asks for tool poses at its own, slower and uneven rate. The tool goes
// after the newest with this time constant, so that it moves evenly between them;
// longer is smoother, and lags more.
constexpr double kFollowSeconds = 0.02;
constexpr double kArrivedDistance = 1e-7;  // m
constexpr double kArrivedAngle = 1e-5;     // rad

bool isFinite(const Pose& pose) {
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite() && pose.orientation.norm() > 0.5;
}

bool samePose(const Pose& a, const Pose& b) {
  return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
}

/// `from`, moved towards `to` by the share `gain` of the way.
Pose follow(const Pose& from, const Pose& to, double gain) {
  if ((to.position - from.position).norm() < kArrivedDistance &&
      from.orientation.angularDistance(to.orientation) < kArrivedAngle) {
    return to;
  }
  Pose pose;
  pose.position = from.position + gain * (to.position - from.position);
  pose.orientation = from.orientation.slerp(gain, to.orientation).normalized();
  return pose;
}

std::int64_t trackEnd(const SimulationLoopOptions& options) {
  if (options.track.empty()) return 0;
  return options.track_ticks > 0 ? options.track_ticks : options.track.back().tick + 1;
}

}  // namespace

SimulationLoop::SimulationLoop(const Model& model, Physics& physics, SpinTeam* team, SimulationLoopOptions options)
    : model_(model),
      physics_(physics),
      team_(team),
      options_(std::move(options)),
      tool_axis_(model.tool_start.orientation * -Vec3::UnitZ()),
      follow_gain_(-std::expm1(-1 / (kFollowSeconds * model.scene.rate_hz))),
      loaded_friction_(model.scene.friction),
      loaded_materials_(model.materials),
      track_end_(trackEnd(options_)),
      commands_(kCommandCapacity),
      snapshots_(makeSnapshot(static_cast<int>(physics.state().u.size()),
                              static_cast<int>(physics.state().contact.vertex.size()),
                              static_cast<int>(model.kernel.materials.size()))),
      forces_(options_.force_capacity),
      log_(kLogCapacity),
      recorded_(options_.record ? options_.record_capacity : 1),
      filter_(model.scene.filter_cutoff_hz, model.scene.force_rate_limit, model.scene.rate_hz),
      watchdog_(model),
      overload_(model.scene.rate_hz),
      shown_u_(physics.state().u),
      friction_(loaded_friction_),
      paused_(options_.start_paused) {
  command_.tool_target = recorded_command_.tool_target = viewer_target_ = model.tool_start;
  publish({});
}

SimulationLoop::~SimulationLoop() {
  quit();
  join();
}

void SimulationLoop::start() {
  thread_ = std::thread([this] { run(); });
}

void SimulationLoop::join() {
  if (thread_.joinable()) thread_.join();
}

void SimulationLoop::run() {
  summary_.rt_setup = setUpLoopThread(team_, !options_.as_fast_as_possible);
  MonotonicClock clock;
  run(clock);
}

void SimulationLoop::run(Clock& clock) {
  FixedStepOptions loop;
  loop.rate_hz = model_.scene.rate_hz;
  loop.as_fast_as_possible = options_.as_fast_as_possible;
  summary_.totals = runFixedStepLoop(loop, clock, *this, statistics_);
  overload_.end(run_tick_, log_);
  summary_.ticks = run_tick_;
  summary_.state_hash = physics_.stateHash();
  summary_.frozen = frozen_;
  finished_.store(true, std::memory_order_release);
}

ForceReading SimulationLoop::force() const {
  const ForceSample sample = newest_force_.latest();
  // After the sample: a reader that was stopped in between must not take it for younger than it is.
  return readForce(sample, MonotonicClock().now());
}

TickOutcome SimulationLoop::onTick(const LoopTime& time) {
  overload_.update(time.begin_ns, run_tick_, log_);
  if (team_ != nullptr) long_waits_ = team_->longWaits();
  takeRequests();
  if (stop_ || quit_.load(std::memory_order_relaxed)) return TickOutcome::Stop;
  if (options_.tick_limit > 0 && run_tick_ >= options_.tick_limit) return TickOutcome::Stop;

  const bool moves = !paused_ || step_once_;
  step_once_ = false;
  if (moves) advance(time);
  publish(time);
  return moves ? TickOutcome::Advanced : TickOutcome::Idle;
}

void SimulationLoop::onLate(const LateTick& measured, const LoopTime& time) {
  LateTick late = measured;
  late.tick = run_tick_ - 1;
  if (team_ != nullptr) late.long_waits = team_->longWaits() - long_waits_;
  std::atomic<std::int64_t>& count = statistics_.late_ticks[static_cast<std::size_t>(causeOf(late))];
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  overload_.add(late, time.begin_ns + late.step_ns, log_);
}

void SimulationLoop::takeRequests() {
  Request request;
  while (commands_.pop(request)) apply(request, false);
}

bool SimulationLoop::trackDrives() const { return options_.motion != nullptr || run_tick_ - track_start_ < track_end_; }

void SimulationLoop::takeTrack() {
  const std::vector<TimedRequest>& track = options_.track;
  while (track_next_ < track.size() && track[track_next_].tick <= run_tick_ - track_start_) {
    apply(track[track_next_++].request, true);
  }
}

void SimulationLoop::apply(const Request& request, bool from_track) {
  using Kind = Request::Kind;
  switch (request.kind) {
    case Kind::Pause:
      if (!paused_) logEvent(LogEvent::Kind::Paused);
      paused_ = true;
      return;
    case Kind::Resume:
      if (paused_ && !(options_.start_paused && run_tick_ == 0)) logEvent(LogEvent::Kind::Resumed);
      paused_ = false;
      return;
    case Kind::SingleStep:
      step_once_ = paused_;
      return;
    case Kind::Quit:
      stop_ = true;
      return;
    case Kind::Reset:
      resetPhysics();
      if (!from_track && !options_.track.empty()) startTrackOver();
      return;
    default:
      break;
  }
  // What is left moves the physics: the track alone may, while it lasts.
  if (!from_track && trackDrives()) return;
  switch (request.kind) {
    case Kind::MoveTool:
      if (!isFinite(request.pose)) return;
      viewer_target_ = request.pose;
      viewer_target_.orientation.normalize();
      if (from_track) command_.tool_target = viewer_target_ = request.pose;
      return;
    case Kind::Pull:
      if (request.index < 0 || request.index >= static_cast<int>(model_.skin.surface.vertices.size()) ||
          !request.point.allFinite()) {
        return;
      }
      command_.pull_vertex = request.index;
      command_.pull_target = request.point;
      return;
    case Kind::ReleasePull:
      command_.pull_vertex = -1;
      command_.pull_target.setZero();
      return;
    case Kind::SetFriction:
      setFriction(request);
      return;
    case Kind::SetMaterial:
      setMaterial(request);
      return;
    default:
      return;
  }
}

/// The force filter is left as it is: the force in a hand goes back smoothly, too.
void SimulationLoop::resetPhysics() {
  physics_.reset();
  watchdog_.reset();
  frozen_ = false;
  report_ = {};
  force_.force_raw.setZero();
  std::copy(physics_.state().u.begin(), physics_.state().u.end(), shown_u_.begin());
  command_ = {};
  command_.tool_target = viewer_target_ = model_.tool_start;
  recorded_command_ = command_;
  if (options_.motion != nullptr) options_.motion->restart();
  record(Request::simple(Request::Kind::Reset));
  logEvent(LogEvent::Kind::Reset);
}

/// A script or replay must find what it found the first time: also friction and materials.
void SimulationLoop::startTrackOver() {
  track_start_ = run_tick_;
  track_next_ = 0;
  setFriction(Request::setFriction(loaded_friction_));
  for (std::size_t m = 0; m < loaded_materials_.size(); ++m) {
    setMaterial(Request::setMaterial(static_cast<int>(m), loaded_materials_[m]));
  }
}

void SimulationLoop::setFriction(const Request& request) {
  if (!std::isfinite(request.value) || request.value < 0) return;
  if (request.value == friction_) return;
  friction_ = request.value;
  physics_.setFriction(request.value);
  record(request);
  logEvent(LogEvent::Kind::FrictionSet, -1, request.value);
}

void SimulationLoop::setMaterial(const Request& request) {
  const double modulus = request.material.waveModulus();
  if (request.index < 0 || request.index >= static_cast<int>(loaded_materials_.size()) || !std::isfinite(modulus) ||
      modulus <= 0) {
    return;
  }
  const double excess = physics_.setMaterial(request.index, request.material);
  if (excess > 0) {
    logEvent(LogEvent::Kind::MaterialRefused, request.index, excess);
    return;
  }
  record(request);
  logEvent(LogEvent::Kind::MaterialSet, request.index);
}

void SimulationLoop::advance(const LoopTime& time) {
  takeTrack();
  if (options_.motion != nullptr && !frozen_) command_.tool_target = options_.motion->next(physics_.state(), report_);
  if (!trackDrives()) command_.tool_target = follow(command_.tool_target, viewer_target_, follow_gain_);
  recordCommand();

  if (!frozen_) {
    if (team_ != nullptr) team_->wake();
    report_ = physics_.tick(command_);
    if (team_ != nullptr && !options_.as_fast_as_possible) team_->park();
    summary_.flags |= report_.flags;
    if (std::isfinite(report_.min_J)) summary_.min_J = std::min(summary_.min_J, report_.min_J);
    force_.doubt = doubtOf(model_, report_);
    if (force_.doubt != Doubt::None && summary_.first_doubt_tick < 0) summary_.first_doubt_tick = run_tick_;
    summary_.doubt = std::max(summary_.doubt, force_.doubt);
    frozen_ = watchdog_.judge(report_, run_tick_, log_);
    if (frozen_) {
      report_.tool_force.setZero();
      report_.base_reaction.setZero();
      report_.contact_count = 0;
    } else {
      std::copy(physics_.state().u.begin(), physics_.state().u.end(), shown_u_.begin());
      summary_.peak_force = std::max(summary_.peak_force, report_.tool_force.norm());
      summary_.base_reaction = report_.base_reaction;
    }
  }
  const bool track_drove = trackDrives();
  ++run_tick_;
  if (track_drove && !trackDrives()) logEvent(LogEvent::Kind::TrackEnded);

  force_.tick = run_tick_;
  force_.wall_ns = time.begin_ns;
  force_.time_s = static_cast<double>(run_tick_) / model_.scene.rate_hz;
  force_.depth_m =
      (physics_.state().tool_pose.position - model_.tool_start.position).dot(tool_axis_) - model_.first_contact_travel;
  force_.force_raw = report_.tool_force;
  force_.force_filtered = frozen_ ? filter_.fade() : filter_.update(force_.force_raw);
  newest_force_.publish(force_);
  if (!forces_.push(force_)) ++summary_.lost_force_samples;
}

void SimulationLoop::publish(const LoopTime& time) {
  const State& state = physics_.state();
  Snapshot& snapshot = snapshots_.back();
  snapshot.tick = state.tick;
  snapshot.time_s = static_cast<double>(state.tick) / model_.scene.rate_hz;
  std::copy(shown_u_.begin(), shown_u_.end(), snapshot.u.begin());
  snapshot.tool_pose = state.tool_pose;
  snapshot.force = force_;
  snapshot.report = report_;

  snapshot.status.ticks = run_tick_;
  snapshot.status.overrun_count = statistics_.overrun_count.load(std::memory_order_relaxed);
  snapshot.status.longest_overrun_streak = statistics_.longest_overrun_streak.load(std::memory_order_relaxed);
  snapshot.status.realtime_factor = time.realtime_factor;
  snapshot.status.recent_realtime_factor = time.recent_realtime_factor;
  snapshot.status.last_step_us = 1e-3F * static_cast<float>(time.last_step_ns);
  snapshot.status.paused = paused_;
  snapshot.status.frozen = frozen_;

  const ContactState& contact = state.contact;
  std::size_t used = 0;
  for (int c = 0; c < contact.count && !frozen_ && used < snapshot.contact_vertex.size(); ++c) {
    const Float4& f = contact.force[static_cast<std::size_t>(c)];
    if (f.x == 0 && f.y == 0 && f.z == 0) continue;
    snapshot.contact_vertex[used] = contact.vertex[static_cast<std::size_t>(c)];
    snapshot.contact_force[used] = f;
    ++used;
  }
  snapshot.contact_count = static_cast<int>(used);
  // The kernel's materials are the ones in force; the vector has its size since the loop was made.
  std::copy(model_.kernel.materials.begin(), model_.kernel.materials.end(), snapshot.materials.begin());
  snapshots_.publish();
}

void SimulationLoop::record(const Request& request) {
  if (options_.record && !recorded_.push({run_tick_, request})) ++summary_.lost_records;
}

void SimulationLoop::recordCommand() {
  if (!samePose(command_.tool_target, recorded_command_.tool_target)) {
    record(Request::moveTool(command_.tool_target));
  }
  if (command_.pull_vertex != recorded_command_.pull_vertex || command_.pull_target != recorded_command_.pull_target) {
    record(command_.pull_vertex < 0 ? Request::simple(Request::Kind::ReleasePull)
                                    : Request::pull(command_.pull_vertex, command_.pull_target));
  }
  recorded_command_ = command_;
}

void SimulationLoop::logEvent(LogEvent::Kind kind, int index, double value) {
  LogEvent event;
  event.kind = kind;
  event.tick = run_tick_;
  event.time_s = static_cast<double>(run_tick_) / model_.scene.rate_hz;
  event.index = index;
  event.value = value;
  log_.push(event);
}

}  // namespace palpate

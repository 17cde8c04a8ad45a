#include "realtime/loop/simulation_loop.h"

#include <utility>

#include "step/tool_bodies.h"

namespace palpate {
namespace {

RunState startOf(const SimulationLoopOptions& options) {
  RunState run;
  run.tick_limit = options.tick_limit;
  run.starts_paused = run.paused = options.start_paused;
  return run;
}

/// Of forces on a cloud that is not the one for where the tools are.
void addError(double expected_error, StepReport& report) {
  if (!(expected_error > 0)) return;
  const auto add = [&](double& of, double& of_force, double force) {
    of = of_force > 0 ? std::max(of, expected_error) : expected_error;
    of_force = std::max(of_force, force);
  };
  add(report.expected_error, report.error_force, report.tool_force.norm());
  for (ToolLoad& load : report.loads)
    if (!load.force.isZero(0)) add(load.expected_error, load.error_force, load.force.norm());
}

}  // namespace

SimulationLoop::SimulationLoop(const Model& model, Physics& physics, SpinTeam* team, SimulationLoopOptions options)
    : model_(model),
      physics_(physics),
      team_(team),
      as_fast_as_possible_(options.as_fast_as_possible),
      keeps_settings_(options.keeps_settings),
      device_(options.device),
      follower_(options.follower),
      track_has_places_(options.track_has_places),
      waits_(options.as_fast_as_possible),
      pause_at_(options.pause_at),
      real_time_(!options.as_fast_as_possible),
      channels_(model, physics.state(), options.force_capacity, options.record ? options.record_capacity : 1),
      run_(startOf(options)),
      track_(std::move(options.track), options.track_ticks, options.motion, model.tools.first().start.pose,
             model.scene.dynamics.rate_hz),
      further_(model),
      history_(physics.state(), model.scene.dynamics.rate_hz, options.undo),
      folds_(model),
      settings_(model, physics),
      reporter_(model, physics, team, channels_) {
  command_ = restCommand(model);
  run_.hand = run_.goal = model.tools.first().start.pose;
  recorder_.startFrom(command_, options.record ? &channels_.recorded : nullptr);
  for (int k = 0; k < model.tools.toolCount(); ++k) proxies_.emplace_back(model, k);
  goOnAtPlace(false);
  reporter_.publish({}, run_);
}

SimulationLoop::~SimulationLoop() {
  quit();
  join();
}

void SimulationLoop::start() {
  if (finished()) {  // once more
    channels_.quit.store(false, std::memory_order_relaxed);
    channels_.finished.store(false, std::memory_order_relaxed);
    run_.stop = false;
  }
  thread_ = std::thread([this] { run(); });
}

void SimulationLoop::join() {
  if (thread_.joinable()) thread_.join();
}

void SimulationLoop::run() {
  reporter_.summary().rt_setup = setUpLoopThread(team_, real_time_);
  MonotonicClock clock;
  run(clock);
}

void SimulationLoop::run(Clock& clock) {
  FixedStepOptions loop;
  loop.rate_hz = model_.scene.dynamics.rate_hz;
  loop.as_fast_as_possible = as_fast_as_possible_;
  loop.catch_up = model_.scene.dynamics.catch_up;
  const LoopTotals totals = runFixedStepLoop(loop, clock, *this, channels_.statistics);
  reporter_.finish(totals, run_, recorder_.lostCount());
  if (follower_ != nullptr) {
    FollowTotals& follow = *reporter_.summary().follow;
    follow.swaps = follower_->swapCount();
    follow.late_ticks = follower_->lateTicks();
    follow.longest_swap_us = follower_->longestSwap();
  }
  channels_.finished.store(true, std::memory_order_release);
}

void SimulationLoop::advanceHere(std::int64_t ticks) {
  const FlushedDenormals flushed;
  channels_.quit.store(false, std::memory_order_relaxed);  // of a thread that ran before
  LoopTime time;
  time.begin_ns = MonotonicClock().now();
  takeRequests();
  takeHand();
  const bool waited = std::exchange(waits_, true);
  for (std::int64_t k = 0; k < ticks; ++k) {
    time.begin_ns = MonotonicClock().now();
    reporter_.beginTick(time, run_);
    if (!advance()) break;
    reporter_.sendForce(time, run_);
    if (listener_ != nullptr) listener_->afterTick();
  }
  waits_ = waited;
  reporter_.publish(time, run_);
}

RunMemory SimulationLoop::memory() const {
  RunMemory memory;
  memory.tick = run_.tick;
  memory.frozen = run_.frozen;
  memory.hand = command_.tools[0].pose;
  memory.pose_sequence = run_.pose_sequence;
  memory.hands = command_.tools;
  memory.further = further_.memory();
  for (std::size_t k = 0; k < proxies_.size(); ++k) memory.proxies[k] = proxies_[k].memory();
  memory.folds = folds_.memory();
  reporter_.tell(memory);
  return memory;
}

void SimulationLoop::record(SpscRing<TimedRequest>* into) { recorder_.startFrom(restCommand(model_), into); }

void SimulationLoop::recall(const RunMemory& memory) {
  // What was sent before is of another future.
  channels_.hand.latest();
  channels_.tool_hands.forget();
  for (Request request; channels_.commands.pop(request);) {
  }
  run_.tick = memory.tick;
  run_.frozen = memory.frozen;
  run_.hand = run_.goal = memory.hand;
  run_.pose_sequence = memory.pose_sequence;
  command_ = restCommand(model_);
  command_.tools[0].pose = memory.hand;
  command_.tools = memory.hands;
  track_.goal().jumpTo(memory.hand);
  if (device_ != nullptr) device_->restart();
  further_.recall(memory.further);
  for (std::size_t k = 0; k < proxies_.size(); ++k) proxies_[k].recall(memory.proxies[k]);
  folds_.recall(memory.folds);
  goOnAtPlace(false);
  history_.startAt(physics_.state());
  settings_.recall();
  reporter_.recall(memory);
  reporter_.publish({}, run_);
}

ForceReading SimulationLoop::force() const {
  const ForceSample sample = channels_.newest_force.latest();
  // After the sample: a reader that was stopped in between must not take it for younger than it is.
  return readForce(sample, MonotonicClock().now(), model_.scene.dynamics.rate_hz);
}

TickOutcome SimulationLoop::onTick(const LoopTime& time) {
  reporter_.beginTick(time, run_);
  takeRequests();
  takeHand();
  if (run_.isOver() || channels_.quit.load(std::memory_order_relaxed)) {
    // What a recording set after its last tick belongs to its last state.
    if (!track_.drives(run_.tick))
      while (const Request* due = track_.takeDue(run_.tick)) apply(*due, true);
    return TickOutcome::Stop;
  }

  const bool moves = !run_.paused || run_.single_steps > 0;
  if (run_.single_steps > 0) --run_.single_steps;
  if (moves) {
    if (!advance()) return TickOutcome::Stop;
    reporter_.sendForce(time, run_);
    if (listener_ != nullptr) listener_->afterTick();
  }
  reporter_.publish(time, run_);
  return moves ? TickOutcome::Advanced : TickOutcome::Idle;
}

void SimulationLoop::onLate(const LateTick& late, const LoopTime& time) { reporter_.addLate(late, time, run_); }

/// @param opening  m, of the first tool; < 0: as it is
void SimulationLoop::openJaws(double opening) {
  if (opening >= 0) further_.take(Request::setOpening(0, opening), command_);
}

/// One tick of the run: the input that takes effect before it, then the physics, unless frozen.
bool SimulationLoop::advance() {
  while (const Request* due = track_.takeDue(run_.tick)) apply(*due, true);
  while (const Request* setting = track_.takeSetting(run_.tick, run_.frozen)) change(*setting);
  if (device_ != nullptr && !run_.frozen && !track_.drives(run_.tick)) {
    moveTool(Request::moveTool(device_->next(physics_.state(), reporter_.lastReport())), true);
    openJaws(device_->opening());
    run_.pose_sequence = device_->poseSequence();
  }
  command_.tools[0].pose =
      track_.next(run_.tick, command_.tools[0].pose, physics_.state(), reporter_.lastReport(), run_.frozen);
  further_.next(run_.tick, command_);
  openJaws(track_.opening(run_.tick, run_.frozen));
  run_.hand = command_.tools[0].pose;
  run_.goal = track_.drives(run_.tick) ? run_.hand : track_.goal().pose();
  if (!run_.frozen && !step()) return false;
  recorder_.addCommand(run_.tick, command_);

  const bool track_drove = track_.drives(run_.tick);
  ++run_.tick;
  if (track_drove && !track_.drives(run_.tick)) reporter_.logEvent(LogEvent::Kind::TrackEnded, run_);
  if (next_pause_ < pause_at_.size() && run_.tick >= pause_at_[next_pause_]) {
    run_.paused = true;
    ++next_pause_;
  }
  return true;
}

/// Where the tools should be in this tick, as far as the tissue lets them, in place of where the hands are.
void SimulationLoop::followHands(Command& command) {
  for (std::size_t k = 0; k < proxies_.size(); ++k) {
    const bool held = !proxies_[k].letsGo();
    command.tools[k] = proxies_[k].follow(command_.tools[k], physics_.state(), reporter_.lastReport());
    command.lets_go[k] = proxies_[k].letsGo();
    if (held && command.lets_go[k]) reporter_.letGo(run_, static_cast<int>(k));
  }
}

bool SimulationLoop::hasFolded(const StepReport& report) {
  const State& state = physics_.state();
  const bool pulled = command_.pull_vertex >= 0 || state.live.loads.any();
  return folds_.update(report, pulled, static_cast<double>(state.step) * model_.dt);
}

/// The physics is at another place, and who reads its nodes with it.
void SimulationLoop::goOnAtPlace(bool swapped) {
  if (follower_ == nullptr) return;
  const std::shared_ptr<ReadyPlace>& place = follower_->place();
  reporter_.goOnAt(place, swapped);
  for (ToolProxy& proxy : proxies_) proxy.goOnWith(place->place.model);
  if (swapped && follower_->letGo() != no_place) history_.forget(follower_->letGo());
  if (!swapped) follower_->restart();
}

/// Before a tick's physics: the cloud is where the tool is. False: quit() came while it was waited for.
bool SimulationLoop::followTool() {
  if (follower_ == nullptr) return true;
  if (track_has_places_ && track_.drives(run_.tick)) {
    follower_->expect(track_.nextPlace());
    return true;
  }
  if (follower_->follow(waits_, channels_.quit)) {
    recorder_.add(run_.tick, Request::goToPlace(follower_->place()->place.index));
    goOnAtPlace(true);
  }
  reporter_.notePlace(follower_->isLate());
  return !channels_.quit.load(std::memory_order_relaxed);
}

bool SimulationLoop::step() {
  if (team_ != nullptr) team_->wake();
  if (!followTool()) {
    if (team_ != nullptr && !as_fast_as_possible_) team_->park();
    return false;
  }
  Command command = command_;
  followHands(command);
  StepReport report = physics_.tick(command);
  if (follower_ != nullptr && report.contact_count > 0) addError(follower_->expectedError(), report);
  if (team_ != nullptr && !as_fast_as_possible_) team_->park();
  run_.yield = proxies_[0].yieldAfter(run_.hand, physics_.state(), report);
  switch (reporter_.judge(report, run_)) {
    case Verdict::Good: {
      if (hasFolded(report)) {
        physics_.reset();  // not to where a recalled run began: that may have been folded
        goOnAtPlace(false);
        history_.clear();
        beGentle();
        reporter_.restored(LogEvent::Kind::RestoredFolded);
        reporter_.logEvent(LogEvent::Kind::RestoredFolded, run_, report.worst_point, report.min_J);
        break;
      }
      if (history_.keep(physics_.state(), reporter_.lastDoubt()) && follower_ != nullptr) follower_->holdOnly(history_);
      break;
    }
    case Verdict::Restore:
      goBackTo(history_.good(reporter_.recentLosses()));
      reporter_.restored(LogEvent::Kind::RestoredBlowUp);
      break;
    case Verdict::Freeze:
      run_.frozen = true;
      break;
  }
  return true;
}

/// The tool is where it was then, too; it will come gently to where the hand is.
void SimulationLoop::goBackTo(const State& past) {
  physics_.restore(past);
  goOnAtPlace(false);
  history_.wentBackTo(past.tick);
  beGentle();
}

void SimulationLoop::beGentle() {
  for (ToolProxy& proxy : proxies_) proxy.beGentle();
  if (device_ != nullptr) device_->restart();
}

}  // namespace palpate

#include "realtime/loop/tick_reporter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "step/tool_bodies.h"
#include "step/tool_contact.h"
#include "step/trust.h"

namespace palpate {

TickReporter::TickReporter(const Model& model, const Physics& physics, const SpinTeam* team, LoopChannels& channels)
    : model_(&model),
      physics_(physics),
      team_(team),
      channels_(channels),
      tool_axis_(model.tools.first().start.pose.orientation * -Vec3::UnitZ()),
      depth_(model.skin, model.scene.tools[0].shape),
      filter_(model.scene.force.cutoff_hz, model.scene.force.rate_limit, model.scene.dynamics.rate_hz),
      watchdog_(model),
      overload_(model.scene.dynamics.rate_hz),
      shown_u_(physics.state().u) {
  shown_u_.reserve(physics.state().u.capacity());
  readings_.count = model.tools.toolCount();
  readTools({});
  channels_.newest_tools.publish(readings_);
}

/// Where the tools are, and what is on them.
void TickReporter::readTools(const RunState& run) {
  readings_.tick = run.tick;
  for (int k = 0; k < static_cast<int>(readings_.count); ++k)
    readings_.set(k, physics_.state().tool[k], report_.loads[static_cast<std::size_t>(k)]);
}

void TickReporter::beginTick(const LoopTime& time, const RunState& run) {
  overload_.update(time.begin_ns, run.tick, channels_.log);
  if (team_ != nullptr) long_waits_ = team_->longWaits();
}

Verdict TickReporter::judge(const StepReport& report, const RunState& run) {
  const Verdict verdict = watchdog_.judge(report, run.tick, channels_.log);
  const std::uint32_t flags = report.flags;
  summary_.flags |= flags;
  force_.doubt = doubtOf(*model_, report);
  force_.expected_error = report.expected_error;
  force_.error_force = report.error_force;
  force_.error_by = report.error_by;
  summary_.trust.add(force_.doubt, report, secondsAt(run.tick + 1));  // when its force goes out
  watchYield(run);
  if (verdict == Verdict::Restore) {  // the report of before, and its force, hold for this tick
    report_.flags = flags;
    return verdict;
  }
  const Vec3 expected = 2 * report_.tool_force - force_before_, before = report_.tool_force;
  force_before_ = report_.tool_force;
  report_ = report;
  if (std::isfinite(report_.min_J)) summary_.min_J = std::min(summary_.min_J, report_.min_J);
  if (verdict == Verdict::Freeze) {
    report_.tool_force.setZero();
    report_.tool_torque.setZero();
    report_.contact_normal.setZero();
    report_.base_reaction.setZero();
    report_.contact_count = 0;
    report_.loads = {};
    return verdict;
  }
  showState();
  watchSwap(expected, before);
  trend_.update(physics_.state().tool[0].pose, report_, model_->scene.dynamics.rate_hz);
  summary_.peak_force = std::max(summary_.peak_force, report_.tool_force.norm());
  for (std::size_t k = 0; k < static_cast<std::size_t>(readings_.count); ++k) {
    summary_.peak_tool_force[k] = std::max(summary_.peak_tool_force[k], report_.loads[k].force.norm());
    summary_.peak_pinch[k] = std::max(summary_.peak_pinch[k], report_.loads[k].pinch);
  }
  summary_.base_reaction = report_.base_reaction;
  summary_.organ_force = report_.organ_force;
  summary_.skin_penetration = std::max(summary_.skin_penetration, report_.skin_penetration);
  for (std::size_t b = 0; b < summary_.rigid.size(); ++b) {
    const double deepest = std::max(summary_.rigid[b].max_penetration, report_.rigid[b].max_penetration);
    summary_.rigid[b] = report_.rigid[b];
    summary_.rigid[b].max_penetration = deepest;
  }
  return verdict;
}

/// Tells of a tool that yields when it begins to, and again when it has not for a second.
void TickReporter::watchYield(const RunState& run) {
  constexpr double kTold = 5e-4, kQuietSeconds = 1;  // m, s
  if (run.yield <= 0) return;
  ++summary_.yielding_ticks;
  summary_.largest_yield = std::max(summary_.largest_yield, run.yield);
  if (run.yield < kTold || !report_.isTouched()) return;
  const bool begins = last_yield_tick_ < 0 || secondsAt(run.tick - last_yield_tick_) > kQuietSeconds;
  last_yield_tick_ = run.tick;
  if (begins) logEvent(LogEvent::Kind::ToolYields, run, report_.loads[0].stopped ? 1 : 0, run.yield);
}

void TickReporter::showState() {
  shown_u_.resize(physics_.state().u.size());  // there is room
  std::copy(physics_.state().u.begin(), physics_.state().u.end(), shown_u_.begin());
}

void TickReporter::goOnAt(const std::shared_ptr<ReadyPlace>& place, bool swapped) {
  model_ = &place->place.model;
  place_ = std::shared_ptr<const Place>(place, &place->place);
  watchdog_.goOnWith(*model_);
  force_.node_count = model_->nodeCount();
  if (!summary_.follow) summary_.follow.emplace();
  swapped_ = swapped;
  showState();
}

/// How far a swap has the force jump. @param expected, before  N
void TickReporter::watchSwap(const Vec3& expected, const Vec3& before) {
  constexpr double least_share = 0.02;  // of the largest force: below, a jump is a share of nearly nothing
  if (!std::exchange(swapped_, false)) return;
  const double jump = (report_.tool_force - expected).norm();
  FollowTotals& follow = *summary_.follow;
  follow.largest_jump_N = std::max(follow.largest_jump_N, jump);
  if (before.norm() > least_share * summary_.peak_force)
    follow.largest_jump_share = std::max(follow.largest_jump_share, jump / before.norm());
}

void TickReporter::restored(LogEvent::Kind cause) {
  ++summary_.restored_count;
  summary_.restores.count(cause);
  trend_.restart(false);
  showState();
}

void TickReporter::letGo(const RunState& run, int tool) {
  ++summary_.let_go_count;
  logEvent(LogEvent::Kind::ToolLetsGo, run, tool);
}

/// Where the first tool is; of jaws their first finger.
Pose TickReporter::firstBody() const { return bodyPose(model_->tools.body[0], physics_.state().tool[0]); }

void TickReporter::sendForce(const LoopTime& time, const RunState& run) {
  force_.tick = run.tick;
  force_.wall_ns = time.begin_ns;
  force_.time_s = secondsAt(run.tick);
  force_.depth_m = depth_.of(firstBody(), physics_.state().contact[0]);
  summary_.peak_depth = std::max(summary_.peak_depth, force_.depth_m);
  force_.advance_m =
      (physics_.state().tool[0].pose.position - model_->tools.first().start.pose.position).dot(tool_axis_) -
      model_->tools.first().first_contact_travel;
  force_.tool_pose = physics_.state().tool[0].pose;
  force_.force_raw = report_.tool_force;
  force_.torque = report_.tool_torque;
  force_.contact_normal = report_.contact_normal;
  force_.stiffness = trend_.stiffness;
  force_.work_J = trend_.work;
  force_.pose_sequence = run.pose_sequence;
  force_.loss_count = summary_.restored_count;
  force_.contact_count = report_.contact_count;
  for (std::size_t b = 0; b < report_.rigid.size(); ++b)
    Eigen::Map<Vec3f>(force_.rigid_force[b].data()) = report_.rigid[b].force.cast<float>();
  force_.frozen = run.frozen;
  force_.force_filtered = run.frozen ? filter_.fade() : filter_.update(force_.force_raw);
  channels_.newest_force.publish(force_);
  readTools(run);
  channels_.newest_tools.publish(readings_);
  // Before its force, and no force without it: whoever takes a force finds the readings that belong to it.
  if (model_->tools.several() && !channels_.tools.push(readings_)) {
    ++summary_.lost_force_samples;
    return;
  }
  if (!channels_.forces.push(force_)) ++summary_.lost_force_samples;
}

void TickReporter::publish(const LoopTime& time, const RunState& run) {
  const State& state = physics_.state();
  const DeadlineStatistics& statistics = channels_.statistics;
  Snapshot& snapshot = channels_.snapshots.back();
  snapshot.tick = state.tick;
  snapshot.time_s = secondsAt(state.tick);
  snapshot.u.resize(shown_u_.size());  // there is room
  std::copy(shown_u_.begin(), shown_u_.end(), snapshot.u.begin());
  snapshot.place = place_;
  snapshot.goal_pose = run.goal;
  snapshot.hand_pose = run.hand;
  snapshot.yield_m = run.yield;
  snapshot.force = force_;
  readTools(run);
  snapshot.tools = readings_;
  snapshot.report = report_;

  snapshot.status.ticks = run.tick;
  snapshot.status.overrun_count = statistics.overrun_count.load(std::memory_order_relaxed);
  snapshot.status.caught_up_count = statistics.caught_up_count.load(std::memory_order_relaxed);
  snapshot.status.longest_overrun_streak = statistics.longest_overrun_streak.load(std::memory_order_relaxed);
  snapshot.status.realtime_factor = time.realtime_factor;
  snapshot.status.recent_realtime_factor = time.recent_realtime_factor;
  snapshot.status.paused = run.paused;
  snapshot.status.frozen = run.frozen;
  snapshot.status.restored_count = summary_.restored_count;
  snapshot.status.undo_count = run.undo_count;
  snapshot.status.reset_tick = run.reset_tick;

  std::size_t used = 0;
  const auto take = [&](int vertex, const Float4& force) {
    if (run.frozen || used >= snapshot.contact_vertex.size()) return;
    snapshot.contact_vertex[used] = vertex;
    snapshot.contact_force[used] = force;
    ++used;
  };
  for (int b = 0; b < model_->tools.bodyCount(); ++b) forEachVertexForce(state.contact[b], take);
  snapshot.contact_count = static_cast<int>(used);
  for (int b = 0; b < model_->tools.bodyCount(); ++b) forEachSampleForce(state.contact[b].samples, take);
  snapshot.contact_entries = static_cast<int>(used);
  // The vector has its size since the channels were made.
  const std::vector<Material>& materials = physics_.state().live.kernel.materials;
  std::copy(materials.begin(), materials.end(), snapshot.materials.begin());
  channels_.snapshots.publish();
}

void TickReporter::addLate(const LateTick& measured, const LoopTime& time, const RunState& run) {
  LateTick late = measured;
  late.tick = run.tick - 1;
  if (team_ != nullptr) late.long_waits = team_->longWaits() - long_waits_;
  std::atomic<std::int64_t>& count = channels_.statistics.late_ticks[static_cast<std::size_t>(causeOf(late))];
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  overload_.add(late, time.begin_ns + late.step_ns, channels_.log);
}

/// The state is another one, and no tick has computed its force yet: until one does, what its contacts hold is shown.
void TickReporter::reset() {
  const State& state = physics_.state();
  watchdog_.reset();
  report_ = {};
  force_.force_raw.setZero();
  for (int b = 0; b < model_->tools.bodyCount(); ++b)
    if (model_->tools.body[b].tool == 0)
      forEachContactForce(state.contact[b], [&](int, const Float4& force) { force_.force_raw -= toVec3(force); });
  force_.force_filtered = force_.force_raw;
  force_.depth_m = depth_.of(firstBody(), state.contact[0]);
  force_.tool_pose = state.tool[0].pose;
  trend_.restart(true);
  showState();
}

void TickReporter::tell(RunMemory& memory) const {
  memory.report = report_;
  memory.force = force_;
  memory.readings = readings_;
  memory.filter = filter_;
  memory.trend = trend_;
}

void TickReporter::recall(const RunMemory& memory) {
  watchdog_.reset();
  report_ = memory.report;
  force_ = memory.force;
  force_.wall_ns = 0;  // of whatever clock: no force for a hand
  filter_ = memory.filter;
  trend_ = memory.trend;
  readings_ = memory.readings;
  channels_.newest_tools.publish(readings_);
  summary_.restored_count = force_.loss_count;
  channels_.newest_force.publish(force_);
  showState();
}

void TickReporter::logEvent(LogEvent::Kind kind, const RunState& run, int index, double value, const Vec3& position) {
  LogEvent event;
  event.kind = kind;
  event.tick = run.tick;
  event.time_s = secondsAt(run.tick);
  event.index = index;
  event.value = value;
  event.position = position;
  channels_.log.push(event);
}

void TickReporter::finish(const LoopTotals& totals, const RunState& run, std::int64_t lost_records) {
  overload_.end(run.tick, channels_.log);
  summary_.totals = totals;
  summary_.ticks = run.tick;
  summary_.state_hash = physics_.stateHash();
  summary_.frozen = run.frozen;
  summary_.lost_records = lost_records;
}

}  // namespace palpate

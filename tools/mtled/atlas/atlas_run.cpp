#include "mtled/atlas/atlas_run.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/interrupt.h"
#include "batch/transient_solver.h"
#include "realtime/loop/fold_watch.h"
#include "realtime/loop/state_history.h"
#include "realtime/loop/tool_proxy.h"
#include "realtime/loop/watchdog.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/trust.h"
#include "step/workspace.h"

namespace palpate::tools {
namespace {

struct Schedule {
  int ticks, still, measured;  // in all; the first of the still ones and of those that are measured
  int early() const { return still + (ticks - still) / 10; }  // the first of the still phase's second tenth
  Schedule(const Model& model, const AtlasDrive& drive)
      : ticks(static_cast<int>(std::lround(drive.seconds * model.scene.rate_hz))),
        still(static_cast<int>(std::lround(drive.still_from * model.scene.rate_hz))),
        measured(ticks - std::max(1, (ticks - still) / 5)) {}
};

struct Mean {
  std::vector<Reaction> sum;
  int count = 0;

  void add(const std::vector<Reaction>& reactions) {
    sum.resize(reactions.size());
    for (std::size_t b = 0; b < reactions.size(); ++b) {
      sum[b].force += reactions[b].force;
      sum[b].moment += reactions[b].moment;
    }
    ++count;
  }
  std::vector<Reaction> value() const {
    std::vector<Reaction> mean = sum;
    for (auto& r : mean) {
      r.force /= count;
      r.moment /= count;
    }
    return mean;
  }
};

const char* lossName(const LogEvent& event) {
  switch (event.kind) {
    case LogEvent::Kind::FrozenNotFinite:
    case LogEvent::Kind::RestoredNotFinite:
      return "not finite";
    case LogEvent::Kind::FrozenBlowUp:
    case LogEvent::Kind::RestoredBlowUp:
      return "blow-up";
    default:
      return "frozen: points inside out";
  }
}

/// A hand's tool, the tissue's earlier states, and who looks for tissue that has folded, as the loop has them.
struct Hand {
  ToolProxy proxy;
  StateHistory history;
  FoldWatch folds;
  const State start;
  const double dt;  // s
  Hand(const Model& model, const State& at_rest)
      : proxy(model), history(at_rest, model.scene.rate_hz), folds(model), start(at_rest), dt(model.dt) {}

  void lead(Command& command, const State& state, const StepReport& last) {
    command.tools[0] = proxy.follow(command.tools[0], state, last);
    command.lets_go[0] = proxy.letsGo();
  }

  /// A tick has ended well. @return whether the tissue had to be put back at rest
  bool putsBack(State& state, const StepReport& report) {
    if (!folds.update(report, false, static_cast<double>(state.step) * dt)) return false;
    const LiveParameters live = state.live;
    state = start;
    state.live = live;
    history.clear();
    proxy.beGentle();
    return true;
  }

  /// The tissue was lost: back to an earlier state, at rest.
  void goBack(State& state, int recent_losses) {
    const LiveParameters live = state.live;
    state = history.good(recent_losses);
    state.live = live;
    std::fill(state.du.begin(), state.du.end(), Float4{});
    state.energy.fresh = true;
    history.wentBackTo(state.tick);
    proxy.beGentle();
  }
};

/// Ticks between two looks at the signals.
constexpr int look_every = 64;

std::vector<Reaction> unknown(const Model& model) {
  return std::vector<Reaction>(model.boundary.motions.size(), {Vec3::Constant(NAN), Vec3::Constant(NAN)});
}

}  // namespace

AtlasRun drive(const Model& model, const AtlasDrive& drive) {
  const Schedule schedule(model, drive);
  const double tick_s = 1 / model.scene.rate_hz;
  AtlasRun run;
  AtlasMeasure& m = run.measure;
  m.nodes = model.nodeCount();
  m.points = model.pointCount();
  Workspace workspace(model, 1);
  Watchdog watchdog(model);
  LogRing log(64);
  State state = initialState(model);
  if (drive.disturb) drive.disturb(state);
  std::optional<Hand> hand;
  if (drive.yields) hand.emplace(model, state);
  if (drive.yields && drive.put_back) hand->proxy.beGentle();
  StepReport last;
  Mean reaction;
  double still_energy = 0, largest_energy = 0;
  for (int k = 0; k < schedule.ticks; ++k) {
    if (k % look_every == 0 && interrupted()) throw AtlasInterrupted();
    const double time = (k + 1) * tick_s;
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    if (drive.command) command = drive.command(time);
    if (hand) hand->lead(command, state, last);
    const StepReport report = last = tick(model, state, command, workspace);
    m.energy_error = std::max(m.energy_error, report.energy_error);
    m.step_share = std::max(m.step_share, report.step_share);
    m.min_J = std::min(m.min_J, static_cast<double>(report.min_J));
    const Doubt doubt = doubtOf(model, report);
    if (doubt > Doubt::Resolution && std::isnan(m.doubt_at) && doubt != Doubt::Lost) {
      m.doubt_at = time;
      m.doubt = doubtName(doubt);
    }
    if (doubt > Doubt::Resolution) m.doubted_for += tick_s;
    const Verdict verdict = watchdog.judge(report, k + 1, log);
    LogEvent event;
    while (log.pop(event))
      if (event.isFreeze() || event.isRestore()) m.loss = lossName(event);
    if (verdict == Verdict::Freeze || (verdict == Verdict::Restore && !hand)) {
      m.lost_at = time;
      break;
    }
    if (verdict == Verdict::Restore) {
      hand->goBack(state, watchdog.recentLosses());
      last = {};
      ++m.restored;
      continue;
    }
    if (hand && hand->putsBack(state, report))
      ++m.restored;
    else if (hand)
      hand->history.keep(state, doubt);
    const double energy = report.strain_energy + report.kinetic_energy;
    if (k == schedule.still) still_energy = largest_energy = energy;
    if (k > schedule.still) largest_energy = std::max(largest_energy, energy);
    const int early_count = schedule.early() - schedule.still;
    if (k >= schedule.early() && k < schedule.early() + early_count)
      run.early_tool_force += report.tool_force / early_count;
    if (k < schedule.measured) continue;
    m.doubted_then = m.doubted_then || doubt > Doubt::Resolution;
    run.tool_force += report.tool_force / (schedule.ticks - schedule.measured);
    reaction.add(workspace.boundary.reaction);
  }
  m.steps = static_cast<double>(state.step);
  m.growth = (largest_energy - still_energy) / std::max(still_energy, model.rest_energy);
  run.reaction = run.lost() ? unknown(model) : reaction.value();
  run.tool = state.tool[0].pose;
  for (const auto& a : state.u) run.u.push_back(toVec3(a));
  return run;
}

std::vector<Reaction> driveInDouble(const Model& model, const AtlasDrive& drive) {
  const Schedule schedule(model, drive);
  TransientSolver solver(model, 1);
  Mean reaction;
  for (int k = 0; k < schedule.ticks; ++k) {
    if (k % look_every == 0 && interrupted()) throw AtlasInterrupted();
    if (!solver.tick().finite) return unknown(model);
    if (k >= schedule.measured) reaction.add(solver.body().reactions());
  }
  return reaction.value();
}

AtlasMeasure compare(const AtlasRun& run, const std::string& what, double value, double truth, double bound) {
  AtlasMeasure measure = run.measure;
  measure.compared = what;
  measure.deviation = (value - truth) / std::abs(truth);
  measure.bound = bound;
  return measure;
}

}  // namespace palpate::tools

#include "mtled/atlas/atlas_run.h"

#include <algorithm>
#include <cmath>

#include "base/interrupt.h"
#include "realtime/loop/simulation_loop.h"
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
      : ticks(static_cast<int>(std::lround(drive.seconds * model.scene.dynamics.rate_hz))),
        still(static_cast<int>(std::lround(drive.still_from * model.scene.dynamics.rate_hz))),
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
  const bool not_finite =
      event.kind == LogEvent::Kind::FrozenNotFinite || event.kind == LogEvent::Kind::RestoredNotFinite;
  return not_finite ? "not finite" : "blow-up";
}

/// What a tick has led to.
enum class Outcome { Goes, Restored, Ends };

/// The body alone: what the watchdog says ends it.
class Bare {
 public:
  Bare(const Model& model, const AtlasDrive& drive)
      : model_(model), workspace_(model, 1), watchdog_(model), state_(initialState(model)) {
    if (drive.disturb) drive.disturb(state_);
  }

  Outcome tick(const Command& command) {
    report_ = palpate::tick(model_, state_, command, workspace_);
    return watchdog_.judge(report_, ++ticks_, log_) == Verdict::Good ? Outcome::Goes : Outcome::Ends;
  }
  const StepReport& report() const { return report_; }
  const State& state() const { return state_; }
  const std::vector<Reaction>& reactions() const { return workspace_.boundary.reaction; }
  LogRing& log() { return log_; }
  std::int64_t restoredCount() const { return 0; }

 private:
  const Model& model_;
  Workspace workspace_;
  Watchdog watchdog_;
  LogRing log_{64};
  State state_;
  StepReport report_;
  std::int64_t ticks_ = 0;
};

/// In the program's loop, under a hand, which has the first tool.
class InLoop {
 public:
  InLoop(const Model& model, const AtlasDrive& drive) : physics_(model, 1), loop_(model, physics_, nullptr, options()) {
    if (drive.put_back) loop_.commands().push(Request::simple(Request::Kind::Reset));
  }

  Outcome tick(const Command& command) {
    const std::int64_t lost = loop_.summary().restores.lost;
    loop_.commands().push(Request::moveTool(command.tools[0].pose));
    loop_.advanceHere(1);
    memory_ = loop_.memory();
    if (memory_.frozen) return Outcome::Ends;
    return loop_.summary().restores.lost > lost ? Outcome::Restored : Outcome::Goes;
  }
  const StepReport& report() const { return memory_.report; }
  const State& state() const { return physics_.state(); }
  const std::vector<Reaction>& reactions() const { return physics_.reactions(); }
  LogRing& log() { return loop_.log(); }
  std::int64_t restoredCount() const { return loop_.summary().restored_count; }

 private:
  static SimulationLoopOptions options() {
    SimulationLoopOptions options;
    options.as_fast_as_possible = true;
    return options;
  }
  TissuePhysics physics_;
  SimulationLoop loop_;
  RunMemory memory_;
};

/// Ticks between two looks at the signals.
constexpr int look_every = 64;

std::vector<Reaction> unknown(const Model& model) {
  return std::vector<Reaction>(model.boundary.motions.size(), {Vec3::Constant(NAN), Vec3::Constant(NAN)});
}

}  // namespace

template <class Body>
static AtlasRun driveIn(Body&& body, const Model& model, const AtlasDrive& drive) {
  const Schedule schedule(model, drive);
  const double tick_s = 1 / model.scene.dynamics.rate_hz;
  AtlasRun run;
  AtlasMeasure& m = run.measure;
  m.nodes = model.nodeCount();
  m.points = model.pointCount();
  Mean reaction;
  double still_energy = 0, largest_energy = 0;
  for (int k = 0; k < schedule.ticks; ++k) {
    if (k % look_every == 0 && interrupted()) throw AtlasInterrupted();
    const double time = (k + 1) * tick_s;
    Command command;
    command.tools[0].pose = model.tools.first().start.pose;
    if (drive.command) command = drive.command(time);
    const Outcome outcome = body.tick(command);
    const StepReport& report = body.report();
    m.energy_error = std::max(m.energy_error, report.energy_error);
    m.step_share = std::max(m.step_share, report.step_share);
    m.min_J = std::min(m.min_J, static_cast<double>(report.min_J));
    const Doubt doubt = doubtOf(model, report);
    if (doubt > Doubt::Resolution && std::isnan(m.doubt_at) && doubt != Doubt::Lost) {
      m.doubt_at = time;
      m.doubt = doubtName(doubt);
    }
    if (doubt > Doubt::Resolution) m.doubted_for += tick_s;
    LogEvent event;
    while (body.log().pop(event))
      if (event.isFreeze() || event.isRestore()) m.loss = lossName(event);
    if (outcome == Outcome::Ends) {
      m.lost_at = time;
      break;
    }
    if (outcome == Outcome::Restored) continue;
    const double energy = report.strain_energy + report.kinetic_energy;
    if (k == schedule.still) still_energy = largest_energy = energy;
    if (k > schedule.still) largest_energy = std::max(largest_energy, energy);
    const int early_count = schedule.early() - schedule.still;
    if (k >= schedule.early() && k < schedule.early() + early_count)
      run.early_tool_force += report.tool_force / early_count;
    if (k < schedule.measured) continue;
    m.doubted_then = m.doubted_then || doubt > Doubt::Resolution;
    run.tool_force += report.tool_force / (schedule.ticks - schedule.measured);
    reaction.add(body.reactions());
  }
  m.restored = static_cast<int>(body.restoredCount());
  m.steps = static_cast<double>(body.state().step);
  m.growth = (largest_energy - still_energy) / std::max(still_energy, model.rest_energy);
  run.reaction = run.lost() ? unknown(model) : reaction.value();
  run.tool = body.state().tool[0].pose;
  for (const auto& a : body.state().u) run.u.push_back(toVec3(a));
  return run;
}

AtlasRun drive(const Model& model, const AtlasDrive& drive) {
  return drive.yields ? driveIn(InLoop(model, drive), model, drive) : driveIn(Bare(model, drive), model, drive);
}

Equilibrium ledTo(const Model& model, const Vec3& place, double tolerance) {
  StaticSolver solver(model, 1, tolerance);
  const Pose start = model.tools.first().start.pose;
  constexpr int load_steps = 6;
  Equilibrium at;
  for (int k = 1; k <= load_steps; ++k) {
    at = solver.advanceTo(0, Pose{start.position + (place - start.position) * k / load_steps, start.orientation});
    if (!at.converged) break;
  }
  return at;
}

AtlasMeasure compare(const AtlasRun& run, const std::string& what, double value, double truth, double bound) {
  AtlasMeasure measure = run.measure;
  measure.compared = what;
  measure.deviation = (value - truth) / std::abs(truth);
  measure.bound = bound;
  return measure;
}

}  // namespace palpate::tools

#include "mtled/bench/bench_run.h"

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "io/load_model.h"
#include "mechanics/internal_forces.h"
#include "mtled/bench/bench_kernels.h"
#include "mtled/bench/timing.h"
#include "mtled/run/progress.h"
#include "mtled/run/scripted_run.h"
#include "realtime/loop/thread_setup.h"
#include "step/step.h"
#include "step/workspace.h"

namespace palpate::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<Vec3> exactForces(const Model& model, const std::vector<Vec3>& u, bool patches) {
  std::vector<Vec3> f;
  referenceInternalForces(model.point_shape, model.point_volume, model.point_material, model.materials, u, f,
                          patches ? model.patches : NodePatches{});
  return f;
}

/// The ceiling that allows least, among arithmetic and the memory level that holds the working set.
void judgeByCeilings(const KernelCost& cost, InstructionSet set, int points, const Ceilings& ceilings, BenchRow& row) {
  // A register holds half as many doubles.
  const double gflops = ceilings.fma_gflops[static_cast<std::size_t>(set)] / (row.precision == "double" ? 2 : 1);
  const MemoryLevel& level = ceilings.levelOf(cost.working_set);
  row.bytes = cost.streamed_bytes / points;
  row.useful_flops = cost.useful_flops / points;
  row.executed_flops = cost.executed_flops / points;
  row.gb_per_s = row.bytes / row.best_ns;
  row.gflop_per_s = row.useful_flops / row.best_ns;
  const double by_arithmetic = row.useful_flops / gflops, by_memory = row.bytes / level.gb_per_s;
  row.ceiling = by_arithmetic > by_memory ? "FMA" : level.name;
  row.ceiling_ns = std::max(by_arithmetic, by_memory);
  row.share = row.ceiling_ns / row.best_ns;
}

using Teams = std::vector<std::unique_ptr<SpinTeam>>;  // one per thread count

void benchForces(const Model& model, const std::vector<Ceilings>& ceilings, Teams& teams, double seconds,
                 bool with_reference, BenchBodyResult& result) {
  const auto u = benchDisplacement(model.X);
  const std::vector<Vec3> exact[] = {exactForces(model, u, false), exactForces(model, u, true)};
  const auto kernels = benchKernels(model, u, ceilings.back().threads, with_reference);
  std::vector<TimedCall> calls;
  std::vector<std::pair<const BenchKernel*, const Ceilings*>> what;  // of each call
  for (const BenchKernel& kernel : kernels)
    for (std::size_t t = 0; t < teams.size(); ++t) {
      if (teams[t]->size() > kernel.max_threads) continue;
      kernel.evaluate(*teams[t]);
      BenchRow row;
      row.kernel = kernel.name;
      row.precision = kernel.precision;
      row.instruction_set = nameOf(kernel.set);
      row.threads = teams[t]->size();
      row.force_error = relativeL2(kernel.forces(), exact[kernel.patches ? 1 : 0]);
      if (!std::isfinite(row.force_error)) row.force_error = std::numeric_limits<double>::infinity();
      row.error_limit = kernel.error_limit;
      result.rows.push_back(row);
      calls.push_back({teams[t].get(), [&kernel, team = teams[t].get()] { kernel.evaluate(*team); }});
      what.emplace_back(&kernel, &ceilings[t]);
    }
  timeInTurns(calls, seconds);
  for (std::size_t k = 0; k < calls.size(); ++k) {
    BenchRow& row = result.rows[k];
    row.best_ns = calls[k].best() / result.points * 1e9;
    row.median_ns = calls[k].median() / result.points * 1e9;
    if (what[k].first->cost.streamed_bytes > 0) {
      judgeByCeilings(what[k].first->cost, what[k].first->set, result.points, *what[k].second, row);
    } else {
      row.bytes = row.useful_flops = row.executed_flops = row.gb_per_s = row.gflop_per_s = row.ceiling_ns = row.share =
          nan;
    }
  }
}

/// The body with the ball pressed into it, slowly.
State pressedState(const Model& model, Command& command) {
  constexpr double depth = 0.003;  // m: under a third of the ball's radius
  command.tools[0].pose = model.tools.first().start.pose;
  command.tools[0].pose.position += (model.tools.first().first_contact_travel + depth) *
                                    (model.tools.first().start.pose.orientation * -Vec3::UnitZ());
  State state = initialState(model);
  Workspace workspace(model, 1);
  setUpLoopThread(&workspace.team, false);
  const double travel = model.tools.first().first_contact_travel + depth;
  const int ticks =
      1 + static_cast<int>(std::ceil(travel / model.scene.tools[0].max_speed * model.scene.dynamics.rate_hz));
  StepReport report;
  for (int k = 0; k < ticks; ++k) report = tick(model, state, command, workspace);
  if (report.flags != 0 || report.contact_count == 0)
    throw std::runtime_error("the step to be timed is not one of contact (flags " + std::to_string(report.flags) +
                             ", " + std::to_string(report.contact_count) + " contacts)");
  return state;
}

void benchSteps(const Model& model, const Teams& teams, double seconds, BenchBodyResult& result) {
  struct Run {
    Workspace workspace;
    State state;
    std::uint32_t flags = 0;
    Run(const Model& m, int threads, const State& start) : workspace(m, threads), state(start) {
      setUpLoopThread(&workspace.team, false);
    }
  };
  Command command;
  const State pressed = pressedState(model, command);
  std::vector<std::unique_ptr<Run>> runs;
  std::vector<TimedCall> calls;
  for (const auto& team : teams) {
    runs.push_back(std::make_unique<Run>(model, team->size(), pressed));
    Run* run = runs.back().get();
    calls.push_back({&run->workspace.team, [&model, &command, run] {
                       run->flags |= tick(model, run->state, command, run->workspace).flags;
                     }});
  }
  timeInTurns(calls, seconds);
  for (std::size_t k = 0; k < calls.size(); ++k) {
    if (runs[k]->flags != 0)
      throw std::runtime_error("the timed steps went wrong (flags " + std::to_string(runs[k]->flags) + ")");
    BenchRow row;
    row.kernel = "whole step";
    row.precision = "float32";
    row.instruction_set = nameOf(chosenInstructionSet());
    row.threads = teams[k]->size();
    const double point_steps = static_cast<double>(result.points) * model.substeps_per_tick;
    row.best_ns = calls[k].best() / point_steps * 1e9;
    row.median_ns = calls[k].median() / point_steps * 1e9;
    row.force_error = row.error_limit = nan;
    row.bytes = row.useful_flops = row.executed_flops = row.gb_per_s = row.gflop_per_s = row.ceiling_ns = row.share =
        nan;
    result.rows.push_back(row);
  }
}

}  // namespace

std::vector<int> benchThreadCounts(int cores) {
  std::vector<int> counts;
  for (int n = 1; n < cores; n *= 2) counts.push_back(n);
  counts.push_back(std::max(1, cores));
  return counts;
}

BenchBodyResult benchBody(const BenchSize& size, const std::vector<Ceilings>& ceilings, double seconds,
                          bool with_reference) {
  BenchBodyResult result;
  ProgressLine progress("bench " + size.name);
  // Set-up is most of the time of the largest body.
  const Model model = loadModel(benchScene(size),
                                [&](const std::string& what, double fraction) { progress.show(0.6 * fraction, what); });
  result.name = size.name;
  result.nodes = model.nodeCount();
  result.points = model.pointCount();
  result.mean_support = model.point_shape.meanSupport();
  result.setup_seconds = model.setup_seconds;

  Teams teams;
  for (const Ceilings& c : ceilings) {
    teams.push_back(std::make_unique<SpinTeam>(c.threads));
    setUpLoopThread(teams.back().get(), false);
  }
  progress.show(0.6, "kernels");
  benchForces(model, ceilings, teams, seconds, with_reference, result);
  progress.show(0.9, "whole step");
  benchSteps(model, teams, seconds, result);
  return result;
}

}  // namespace palpate::tools

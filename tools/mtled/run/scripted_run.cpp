#include "mtled/run/scripted_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/interrupt.h"
#include "batch/transient_solver.h"
#include "io/indent_script.h"
#include "setup/body_points.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/tool_bodies.h"

namespace palpate::tools {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double head_start = 1e-3;  // m above the skin, where the built-in way begins
constexpr double hold_seconds = 0.25;

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return NAN;
  const auto at = static_cast<std::size_t>(
      std::min(q * static_cast<double>(values.size()), static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

/// @param tickTo  advances to where the tools are then; adds what that came to
template <class TickTo>
void follow(const ToolTrajectory& way, ScriptedRun& run, TickTo&& tickTo) {
  for (const ToolPostures& tools : way) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) return;
    const auto start = Clock::now();
    tickTo(tools);
    run.tick_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
}

void followInFloat(const Model& model, const ToolTrajectory& way, int threads, const std::function<void(double)>& watch,
                   ScriptedRun& run, AlignedVector<Double4>& u) {
  SteppedTissue tissue(model, stateAt(model, way.front()), threads);
  tissue.workspace.team.wake();
  std::size_t ticks = 0;
  follow(way, run, [&](const ToolPostures& tools) {
    const StepReport report = tissue.tickTo(tools);
    run.add(model, report.loads, report.flags, static_cast<double>(report.min_J));
    if (watch) watch(static_cast<double>(++ticks) / static_cast<double>(way.size()));
  });
  tissue.workspace.team.park();
  u = inDouble(tissue.state.u);
}

void followInDouble(const Model& model, const ToolTrajectory& way, int threads, ScriptedRun& run,
                    AlignedVector<Double4>& u) {
  const auto all = [&](const ToolPostures& tools) {
    ToolsAt at;
    at.count = model.tools.toolCount();
    at.posture = tools;
    return at;
  };
  TransientSolver solver(model, threads);
  solver.resume(0, AlignedVector<Double4>(model.X.size()), AlignedVector<Double4>(model.X.size()), all(way.front()));
  follow(way, run, [&](const ToolPostures& tools) {
    const auto report = solver.tick(all(tools));
    std::uint32_t flags = 0;
    if (!report.finite) flags |= kNotFinite;
    if (report.inverted_points > 0) flags |= kInvertedPoints;
    if (report.max_increment > model.max_increment) flags |= kBlowUp;
    run.add(model, report.loads, flags, report.min_J);
  });
  u = solver.body().u;
}

}  // namespace

ToolTrajectory othersStand(const std::vector<ToolPosture>& first, const Model& model) {
  ToolTrajectory way(first.size(), restCommand(model).tools);
  for (std::size_t k = 0; k < first.size(); ++k) way[k][0] = first[k];
  return way;
}

ToolTrajectory scriptedTrajectory(const Model& model, const std::optional<ToolScript>& script) {
  const ToolSetUp& first = model.tools.first();
  std::vector<ToolPosture> postures = scriptWay(script ? *script : indentScript(model), model);
  if (!model.tools.several()) {
    const Vec3 axis = first.start.pose.orientation * -Vec3::UnitZ();
    const auto near = [&](const ToolPosture& at) {
      return (at.pose.position - first.start.pose.position).dot(axis) > first.first_contact_travel - head_start;
    };
    postures.erase(postures.begin(), std::find_if(postures.begin(), postures.end() - 1, near));
  }
  if (!script)
    postures.insert(postures.end(), static_cast<std::size_t>(std::lround(hold_seconds * model.scene.dynamics.rate_hz)),
                    postures.back());
  ToolTrajectory way = othersStand(postures, model);
  for (std::size_t t = 1; t < model.tools.tool.size(); ++t) {
    const std::vector<ToolPosture>& path = model.tools.tool[t].path;
    if (path.size() > way.size()) way.resize(path.size(), way.back());
    for (std::size_t k = 0; k < way.size() && !path.empty(); ++k) way[k][t] = path[std::min(k, path.size() - 1)];
  }
  return way;
}

bool ScriptedRun::sound() const {
  return !force.empty() && !interrupted && (flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0;
}

double ScriptedRun::peakForce() const {
  double peak = 0;
  for (const Vec3& f : force) peak = std::max(peak, f.norm());
  return peak;
}

void ScriptedRun::add(const Model& model, const ToolLoads& loads, std::uint32_t more_flags, double tick_min_J) {
  for (std::size_t t = 0; t < model.tools.tool.size(); ++t) {
    force.push_back(loads[t].force);
    if (model.tools.tool[t].jaws) force.emplace_back(loads[t].pinch, 0, 0);
  }
  flags |= more_flags;
  min_J = std::min(min_J, static_cast<float>(tick_min_J));
}

StepReport SteppedTissue::tickTo(const ToolPostures& tools) {
  Command command;
  command.moves_others = true;
  command.tools = tools;
  return tick(model, state, command, workspace);
}

State stateAt(const Model& model, const ToolPostures& tools) {
  State state = initialState(model);
  std::copy_n(tools.begin(), state.tool.size(), state.tool.begin());
  return state;
}

ScriptedRun runTrajectory(const Model& model, const ToolTrajectory& way, const std::vector<Vec3>& probes, int threads,
                          bool in_double, const std::function<void(double)>& watch) {
  const ShapeTable shape = shapeAt(model, probes);
  ScriptedRun run;
  AlignedVector<Double4> u;
  if (in_double)
    followInDouble(model, way, threads, run, u);
  else
    followInFloat(model, way, threads, watch, run, u);
  run.probe_u = fieldAt(shape, u);
  return run;
}

std::vector<Vec3> displacementAt(const Model& model, const std::vector<Vec3>& probes, const State& state) {
  return fieldAt(shapeAt(model, probes), inDouble(state.u));
}

double relativeL2(const std::vector<Vec3>& computed, const std::vector<Vec3>& reference) {
  double difference = 0, size = 0;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    difference += (computed[k] - reference[k]).squaredNorm();
    size += reference[k].squaredNorm();
  }
  return std::sqrt(difference / size);
}

RunError errorOf(const ScriptedRun& run, const ScriptedRun& better) {
  if (run.force.size() != better.force.size() || run.probe_u.size() != better.probe_u.size()) return {NAN, NAN, NAN};
  double sum = 0, largest = 0;
  int count = 0;
  for (std::size_t k = 0; k < better.force.size(); ++k) {
    const double size = better.force[k].norm();
    if (size == 0) continue;
    largest = std::max(largest, size);
    sum += (run.force[k] - better.force[k]).squaredNorm();
    ++count;
  }
  RunError error;
  error.force = count > 0 ? std::sqrt(sum / count) / largest : NAN;
  for (std::size_t k = 0; k < better.force.size(); ++k) {
    const double size = better.force[k].norm();
    if (size > 0 && size >= 0.5 * largest)
      error.loaded = std::max(error.loaded, (run.force[k] - better.force[k]).norm() / size);
  }
  sum = largest = 0;
  for (std::size_t k = 0; k < better.probe_u.size(); ++k) {
    largest = std::max(largest, better.probe_u[k].norm());
    sum += (run.probe_u[k] - better.probe_u[k]).squaredNorm();
  }
  error.displacement = largest > 0 ? std::sqrt(sum / static_cast<double>(better.probe_u.size())) / largest : NAN;
  return error;
}

double trembleOf(const ScriptedRun& run, const ToolTrajectory& way) {
  constexpr std::ptrdiff_t least_ticks = 10;
  const auto stands = [&](const ToolPostures& tools) {
    for (std::size_t t = 0; t < tools.size(); ++t)
      if (tools[t].pose.position != way.back()[t].pose.position || tools[t].opening != way.back()[t].opening ||
          !tools[t].pose.orientation.isApprox(way.back()[t].pose.orientation))
        return false;
    return true;
  };
  const auto standing = std::find_if_not(way.rbegin(), way.rend(), stands) - way.rbegin();
  const double peak = run.peakForce();
  if (standing < least_ticks || peak == 0) return 0;
  const std::size_t forces = run.force.size() / way.size(), end = run.force.size(),
                    begin = end - static_cast<std::size_t>(standing / 2) * forces;
  double sum = 0;
  for (std::size_t k = begin + 2 * forces; k < end; ++k)
    sum += (run.force[k] - 2 * run.force[k - forces] + run.force[k - 2 * forces]).squaredNorm();
  return std::sqrt(sum / 6 / static_cast<double>((end - begin) / forces - 2)) / peak;  // of noise of variance 1: 6
}

RunCost costOf(const ScriptedRun& run, double rate_hz) {
  const double total = std::accumulate(run.tick_us.begin(), run.tick_us.end(), 0.0);
  return {total / static_cast<double>(run.tick_us.size()) * rate_hz * 1e-3, quantile(run.tick_us, 0.5),
          quantile(run.tick_us, 0.999)};
}

}  // namespace palpate::tools

#include "mtled/run/scripted_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "base/interrupt.h"
#include "batch/transient_solver.h"
#include "io/certificate.h"
#include "io/indent_script.h"
#include "scene/scene_messages.h"
#include "setup/body_points.h"
#include "setup/build_model.h"
#include "step/step.h"
#include "step/workspace.h"

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

ShapeTable probeShape(const Model& model, const std::vector<Vec3>& probes) {
  std::vector<InadmissibleSupport> failed;
  ShapeTable shape = shapeAt(model, probes, failed);
  if (!failed.empty()) throw std::runtime_error("a probe lies outside the body");
  return shape;
}

AlignedVector<Double4> inDouble(const AlignedVector<Float4>& u) {
  AlignedVector<Double4> result;
  for (const Float4& a : u) result.push_back({a.x, a.y, a.z, 0});
  return result;
}

/// @param tickTo  advances to a pose; fills force, flags and min_J
template <class TickTo>
void follow(const ToolTrajectory& way, ScriptedRun& run, TickTo&& tickTo) {
  for (const Pose& pose : way) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) return;
    const auto start = Clock::now();
    tickTo(pose);
    run.tick_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
}

void followInFloat(const Model& model, const ToolTrajectory& way, int threads, ScriptedRun& run,
                   AlignedVector<Double4>& u) {
  Workspace workspace(model, threads);
  State state = initialState(model);
  state.tool[0].pose = way.front();
  workspace.team.wake();
  follow(way, run, [&](const Pose& pose) {
    Command command;
    command.tools[0].pose = pose;
    const StepReport report = tick(model, state, command, workspace);
    run.force.push_back(report.tool_force);
    run.flags |= report.flags;
    run.min_J = std::min(run.min_J, report.min_J);
  });
  workspace.team.park();
  u = inDouble(state.u);
}

void followInDouble(const Model& model, const ToolTrajectory& way, int threads, ScriptedRun& run,
                    AlignedVector<Double4>& u) {
  TransientSolver solver(model, threads);
  solver.resume(0, AlignedVector<Double4>(model.X.size()), AlignedVector<Double4>(model.X.size()), way.front());
  follow(way, run, [&](const Pose& pose) {
    const auto report = solver.tick(pose);
    run.force.push_back(report.tool_force);
    if (!report.finite) run.flags |= kNotFinite;
    if (report.inverted_points > 0) run.flags |= kInvertedPoints;
    if (report.max_increment > model.max_increment) run.flags |= kBlowUp;
    run.min_J = std::min(run.min_J, static_cast<float>(report.min_J));
  });
  u = solver.body().u;
}

}  // namespace

void checkOneWay(const Scene& scene, const std::string& command) {
  if (hasOneWay(scene)) return;
  throw InputError(placeOf(scene, scene.tools.size() > 1 ? "tool[1].shape" : "tool.opening"),
                   "`mtled " + command + "` goes one tool's way, and has no " +
                       (scene.tools.size() > 1 ? "further tools" : "jaws that open and close"),
                   "compare `mtled solve` on this spacing and a finer one, or go by the expected error of a run");
}

ToolTrajectory indentationTrajectory(const Model& model) {
  const auto poses = scriptPoses(indentScript(model), model);
  const Vec3 axis = model.tools.first().start.pose.orientation * -Vec3::UnitZ();
  const auto near = [&](const Pose& p) {
    return (p.position - model.tools.first().start.pose.position).dot(axis) >
           model.tools.first().first_contact_travel - head_start;
  };
  ToolTrajectory way(std::find_if(poses.begin(), poses.end() - 1, near), poses.end());
  way.insert(way.end(), static_cast<std::size_t>(std::lround(hold_seconds * model.scene.dynamics.rate_hz)),
             poses.back());
  return way;
}

bool ScriptedRun::sound() const {
  return !force.empty() && !interrupted && (flags & (kNotFinite | kBlowUp | kInvertedPoints)) == 0;
}

ScriptedRun runTrajectory(const Model& model, const ToolTrajectory& way, const std::vector<Vec3>& probes, int threads,
                          bool in_double) {
  const ShapeTable shape = probeShape(model, probes);
  ScriptedRun run;
  AlignedVector<Double4> u;
  if (in_double)
    followInDouble(model, way, threads, run, u);
  else
    followInFloat(model, way, threads, run, u);
  run.probe_u = fieldAt(shape, u);
  return run;
}

std::vector<Vec3> displacementAt(const Model& model, const std::vector<Vec3>& probes, const State& state) {
  return fieldAt(probeShape(model, probes), inDouble(state.u));
}

RunError errorOf(const ScriptedRun& run, const ScriptedRun& better) {
  if (run.force.size() != better.force.size() || run.probe_u.size() != better.probe_u.size()) return {NAN, NAN};
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
  sum = largest = 0;
  for (std::size_t k = 0; k < better.probe_u.size(); ++k) {
    largest = std::max(largest, better.probe_u[k].norm());
    sum += (run.probe_u[k] - better.probe_u[k]).squaredNorm();
  }
  error.displacement = largest > 0 ? std::sqrt(sum / static_cast<double>(better.probe_u.size())) / largest : NAN;
  return error;
}

RunCost costOf(const ScriptedRun& run, double rate_hz) {
  const double total = std::accumulate(run.tick_us.begin(), run.tick_us.end(), 0.0);
  return {total / static_cast<double>(run.tick_us.size()) * rate_hz * 1e-3, quantile(run.tick_us, 0.5),
          quantile(run.tick_us, 0.999)};
}

}  // namespace palpate::tools

#include "mtled/solve/solve_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/interrupt.h"
#include "base/key.h"
#include "base/parallel_for.h"
#include "batch/batch_tools.h"
#include "batch/static_solver.h"
#include "batch/transient_solver.h"
#include "discretization/surface/surface_geometry.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "model/model_hash.h"
#include "mtled/run/checkpoint.h"
#include "mtled/run/progress.h"
#include "mtled/solve/solve_results.h"
#include "mtled/solve/solve_tools.h"
#include "scene/scene_messages.h"
#include "setup/free_axes.h"
#include "step/resolution.h"
#include "step/rigid_stop.h"
#include "step/tool_bodies.h"

namespace palpate::tools {
namespace {

using Seconds = std::chrono::duration<double>;

/// Time after which nothing moves any more, s.
double endTime(const Scene& scene, const SolveTools& tools) {
  if (scene.solve.end_time > 0) return scene.solve.end_time;
  const double end = std::max(tools.duration(), motionEnd(scene));
  if (end <= 0 && !scene.dynamics.gravity.isZero(0)) return 1;  // the weight is there from the start
  if (end <= 0)
    throw InputError(scene.solve.place.file.empty() ? scene.place : scene.solve.place,
                     "nothing moves in this scene, so there is no time to solve to",
                     "add a [[prescribed]] motion, a [[load]], --tool SCRIPT or a tool's input = \"script:FILE\", or "
                     "set end_time in [solve]");
  return end;
}

/// The scene file that a word means: a case's folder has one of this name.
std::string sceneFileOf(const std::string& scene) {
  std::error_code error;
  if (std::filesystem::is_directory(scene, error)) return (std::filesystem::path(scene) / "scene.toml").string();
  return findScene(scene);
}

/// Where results go if nothing is said.
std::string usualFolder(const SolveOptions& options, const std::string& file) {
  std::error_code error;
  if (std::filesystem::is_directory(options.scene, error))
    return (std::filesystem::path(options.scene) / "solution").string();
  return "out/" + std::filesystem::path(file).stem().string();
}

/// Ticks of a motion to a time, a whole number; at least one.
double ticksTo(double end, const Scene& scene) {
  return std::max(1.0, std::ceil(end / (1 / scene.dynamics.rate_hz) - 1e-9));
}

/// A motion that would fill every disk with its force curve is a typing error.
void checkLength(const Scene& scene, double end) {
  constexpr double max_ticks = 1e8;
  if (scene.solve.mode != SolveSpec::Mode::Transient || ticksTo(end, scene) <= max_ticks) return;
  const std::string advice =
      "a transient solution can have 1e8, " + number(max_ticks / scene.dynamics.rate_hz) + " s; ";
  throw InputError(scene.places.contains("solve.end_time") ? placeOf(scene, "solve.end_time")
                   : scene.solve.place.file.empty()        ? scene.place
                                                           : scene.solve.place,
                   "the motion to " + number(end) + " s has " + number(ticksTo(end, scene)) + " ticks",
                   advice + (scene.solve.end_time > 0 ? "lower end_time" : "set end_time in [solve]"));
}

/// What jaws hold they hold by friction, and that depends on how they came there: in a static solution there is no way
/// but the relaxation's, in which they slip.
void checkTools(const Scene& scene) {
  if (scene.solve.mode == SolveSpec::Mode::Transient) return;
  for (const ToolSpec& tool : scene.tools)
    if (tool.jaws())
      throw InputError(tool.place, "a static solution has no way along which jaws could take hold",
                       "set mode = \"transient\" in [solve], or leave \"opening\" out");
}

bool hasFriction(const Scene& scene) {
  const std::vector<ToolSpec>& tools = scene.tools;
  return std::any_of(tools.begin(), tools.end(), [](const ToolSpec& tool) { return tool.friction > 0; });
}

/// Of all that decides a solution: what a checkpoint must agree in.
std::uint64_t identityOf(const Model& model, const SolveTools& tools, double end) {
  ByteKey key;
  key.add(modelHash(model), model.scene.solve.mode);
  // What a load step is; more of the same may follow.
  if (model.scene.solve.mode == SolveSpec::Mode::Static) key.add(end / model.scene.solve.load_steps);
  tools.addTo(key);
  return key.hash();
}

struct Task {
  const Model& model;
  const SolveTools& tools;
  double end;
  int threads;
  bool resume;

  ToolsAt toolsAt(double time) const { return tools.at(model, time); }

  /// The times that a load step goes over, its end last. Friction is of ways: in two steps of a quarter of the radius
  /// each a ball that presses had up to a quarter of its force aside for a tenth, from twentieths on 1 % more or less.
  std::vector<double> timesOf(std::int64_t load_step) const {
    constexpr double longest = 0.05;  // of a tool's radius
    constexpr int most = 40;          // pieces: a tool that comes from afar through air
    const auto at = [&](double k) { return end * k / model.scene.solve.load_steps; };
    const double from = at(static_cast<double>(load_step - 1)), to = at(static_cast<double>(load_step));
    const ToolsAt before = toolsAt(from), after = toolsAt(to);
    double pieces = 1;
    const std::size_t rubbing = hasFriction(model.scene) ? static_cast<std::size_t>(after.count) : 0;
    const double of_body = rubbing > 0 ? bodysWay(from, to) : 0;
    for (std::size_t t = 0; t < rubbing; ++t) {
      const double way = (after.posture[t].pose.position - before.posture[t].pose.position).norm() + of_body;
      pieces = std::max(pieces, std::ceil(way / (longest * model.scene.tools[t].shape.radius) - 1e-9));
    }
    std::vector<double> times;
    const int count = static_cast<int>(std::min<double>(pieces, most));
    for (int p = 1; p < count; ++p) times.push_back(from + (to - from) * p / count);
    times.push_back(to);
    return times;
  }

  /// m, that prescribed motions move the body at most.
  double bodysWay(double from, double to) const {
    const Box3 box = boundingBox(model.skin.surface);
    double way = 0;
    for (const BoundaryMotion& motion : model.essential.motions)
      for (int c = 0; motion.moves() && c < 8; ++c) {
        const Vec3 X = box.corner(static_cast<Box3::CornerType>(c));
        way = std::max(way, (motion.at(X, to) - motion.at(X, from)).norm());
      }
    return way;
  }

  /// Where they are at the end of some times, one after the other: what is rigid may have stopped them.
  ToolsAt toolsAfter(const std::vector<double>& times, SolveResults& results) const {
    ToolsAt at = BatchTools(model).at();
    for (const double time : times) {
      at = stoppedByRigid(model, at, toolsAt(time), time);
      results.compareTools(time, toolsAt(time), at);
    }
    return at;
  }
};

int solveStatic(const Task& task, SolveResults& results) {
  const auto start = std::chrono::steady_clock::now();
  const SolveSpec& spec = task.model.scene.solve;
  StaticSolver solver(task.model, task.threads, spec.tolerance);
  if (task.resume) {
    std::vector<double> times{0};
    for (std::int64_t k = 1; k <= results.checkpoint().position; ++k)
      for (const double time : task.timesOf(k)) times.push_back(time);
    solver.resume(times.back(), results.checkpoint().u, task.toolsAfter({times.begin() + 1, times.end()}, results),
                  results.checkpoint().largest);
  }
  ProgressLine progress("solve");
  int iterations = 0;
  Equilibrium e;
  e.converged = true;
  for (std::int64_t k = results.checkpoint().position + 1; k <= spec.load_steps; ++k) {
    Equilibrium whole;  // of the load step
    const auto watch = [&](int of_piece) {
      // A load step takes a few hundred iterations; the bar moves within it, and never past it.
      const int of_step = whole.iterations + of_piece;
      const double within = 1 - std::exp(-of_step / 400.0);
      progress.show((k - 1 + within) / spec.load_steps, "load step " + std::to_string(k) + " of " +
                                                            std::to_string(spec.load_steps) + ", iteration " +
                                                            std::to_string(of_step));
      return !interrupted();
    };
    const std::vector<double> times = task.timesOf(k);
    const double time = times.back();
    for (const double at : times) {
      e = solver.advanceTo(at, task.toolsAt(at), watch);
      e.iterations += whole.iterations;
      // First touch is never resolved, and of no weight at the end.
      if (whole.doubt != Doubt::Resolution) e.doubt = std::max(e.doubt, whole.doubt);
      e.inverted_points = std::max(e.inverted_points, whole.inverted_points);
      if (whole.min_J < e.min_J) e.min_J = whole.min_J, e.worst_point = whole.worst_point;
      whole = e;
      if (!e.converged) break;
    }
    iterations += e.iterations;
    if (!e.converged) break;
    results.add({k, time, e.error, e.iterations, e.min_J, e.inverted_points, e.loads, e.rigid, solver.largestSoFar(),
                 e.doubt, e.expected_error, e.worst_point},
                solver.body(), task.toolsAt(time));
  }
  results.finish({{"mode", "static"},
                  {"converged", e.converged},
                  {"diverged", e.diverged},
                  {"interrupted", e.interrupted},
                  {"iterations", iterations},
                  {"error_estimate_m", results.error()},
                  {"solve_seconds", Seconds(std::chrono::steady_clock::now() - start).count()}});
  if (e.diverged) {
    std::cerr << "mtled: the load step to " << e.time
              << " s diverged; the results end before it. More load_steps in [solve], "
              << "a coarser spacing or less motion may help\n";
  } else if (!e.converged && !e.interrupted) {
    std::cerr
        << "mtled: no equilibrium within the tolerance at " << e.time << " s after " << StaticSolver::max_iterations
        << " iterations; the results end before it"
        << (task.toolsAt(e.time) && hasFriction(task.model.scene)
                ? "; a point may stick and slip by turns: another number of load_steps in [solve], or less "
                  "friction, may help\n"
                : "; what hardly holds it (a small patch, soft tissue about it) lets it swing for long: hold more "
                  "of it, or let it settle in time, mode = \"transient\" in [solve]\n");
  }
  if (e.interrupted) std::cerr << "mtled: interrupted; --resume goes on from the last load step\n";
  return e.converged && !e.diverged && !e.interrupted ? 0 : 1;
}

int solveTransient(const Task& task, SolveResults& results) {
  const auto start = std::chrono::steady_clock::now();
  TransientSolver solver(task.model, task.threads);
  const double tick = 1 / task.model.scene.dynamics.rate_hz;
  if (task.resume) {
    results.checkHistory(solver.body().history());
    std::vector<double> times;
    for (std::int64_t k = 1; k <= results.checkpoint().position / task.model.substeps_per_tick; ++k)
      times.push_back(static_cast<double>(k) * tick);
    solver.resume(results.checkpoint().position, results.checkpoint().u, results.checkpoint().du,
                  task.toolsAfter(times, results), results.checkpoint().history);
  }
  ProgressLine progress("solve");
  const auto ticks = static_cast<std::int64_t>(ticksTo(task.end, task.model.scene));
  // What the cloud's fineness is worth takes as long to find as a step: of some ticks, and the last.
  const std::int64_t interval = 1 + ticks / 200;
  double expected_error = results.expectedError();
  bool stopped = false, diverged = false;
  for (std::int64_t k = solver.step() / task.model.substeps_per_tick + 1; k <= ticks && !stopped && !diverged; ++k) {
    const auto report = solver.tick(task.toolsAt(static_cast<double>(k) * tick), [] { return !interrupted(); });
    stopped = !report;
    if (stopped) break;
    diverged = !report->finite || report->max_increment > task.model.max_increment;
    if (k % interval == 0 || k == ticks)
      expected_error =
          std::hypot(expectedError(task.model, task.model.materials, solver.body().u, report->strain_energy,
                                   PressList(report->loads), solver.body().tools().posture),
                     solver.body().rimShare(report->loads));
    const Doubt unresolved = expected_error > TrustLimits::expected_error ? Doubt::Resolution : Doubt::None;
    if (!diverged)
      results.add({solver.step(),
                   solver.time(),
                   {},
                   task.model.substeps_per_tick,
                   report->min_J,
                   report->inverted_points,
                   report->loads,
                   report->contact.rigid,
                   0,
                   std::max(report->doubt, unresolved),
                   expected_error,
                   report->worst_point},
                  solver.body(), task.toolsAt(static_cast<double>(k) * tick));
    char detail[64];
    std::snprintf(detail, sizeof detail, "%.4g of %.4g s", solver.time(), task.end);
    progress.show(static_cast<double>(k) / static_cast<double>(ticks), detail);
    stopped = interrupted();
  }
  results.finish({{"mode", "transient"},
                  {"diverged", diverged},
                  {"interrupted", stopped},
                  {"dt_s", task.model.dt},
                  {"dt_critical_s", task.model.dt_critical},
                  {"added_mass", task.model.addedMass()},
                  {"steps", solver.step()},
                  {"solve_seconds", Seconds(std::chrono::steady_clock::now() - start).count()}});
  if (diverged)
    std::cerr << "mtled: the motion blew up at " << solver.time() << " s (step " << task.model.dt
              << " s, stable at rest to " << task.model.dt_critical << " s); lower dynamics.step_safety\n";
  if (stopped) std::cerr << "mtled: interrupted; --resume goes on\n";
  return diverged || stopped ? 1 : 0;
}

}  // namespace

int solveCommand(const SolveOptions& options) {
  const std::string file = sceneFileOf(options.scene);
  const Scene scene = readScene(file);
  checkTools(scene);
  const SolveTools moved(scene, options.tool_script);
  if (scene.solve.mode == SolveSpec::Mode::Static) requireUniqueEquilibrium(scene);
  const double end = endTime(scene, moved);
  checkLength(scene, end);
  std::unique_ptr<Model> model;
  {
    ProgressLine progress("set-up");
    const ModelCache cache(options.use_cache ? ModelCache::userFolder() : "", warn);
    const auto show = [&](const std::string& what, double fraction) {
      if (interrupted()) throw std::runtime_error("interrupted while the model was made");
      progress.show(fraction, what);
    };
    // Where the cloud follows the tool, it is the one for where the tool ends.
    const auto at_end = [&](const Model& start) {
      const ToolsAt tools = moved.at(start, end);
      return tools ? tools.posture : posturesOf(initialState(start));
    };
    model = std::make_unique<Model>(loadModel(scene, show, cache, warn, at_end));
  }
  const int cores = threadsOr(0);
  if (const std::string loose = looseWarning(*model); !loose.empty()) warn(loose);
  if (const std::string layer = layerWarning(*model); !layer.empty()) warn(layer);
  if (const std::string coarse = resolutionWarning(*model); moved.moved() && !coarse.empty()) warn(coarse);
  SolveResults results(*model, options.out.empty() ? usualFolder(options, file) : options.out, end,
                       identityOf(*model, moved, end), options.resume);
  std::cout << scene.name << ": " << model->nodeCount() << " nodes, " << model->pointCount()
            << " integration points, set up in " << model->setup_seconds << " s" << std::endl;
  const Task task{*model, moved, end, options.threads > 0 ? options.threads : cores, options.resume};
  const int code =
      scene.solve.mode == SolveSpec::Mode::Static ? solveStatic(task, results) : solveTransient(task, results);
  results.print();
  return code == 0 && options.strict && results.doubt() != Doubt::None ? 3 : code;
}

AlignedVector<Double4> solutionOf(const Model& model, const std::string& folder) {
  const std::string file = (std::filesystem::path(folder) / "checkpoint.bin").string();
  const SolveTools tools(model.scene, "");
  const std::uint64_t identity = identityOf(model, tools, endTime(model.scene, tools));
  const Checkpoint checkpoint = readCheckpoint(file, identity, model.X.size());
  if (model.scene.solve.mode == SolveSpec::Mode::Static && checkpoint.position < model.scene.solve.load_steps)
    warn(file + ": the solution ends before the last load step");
  return checkpoint.u;
}

}  // namespace palpate::tools

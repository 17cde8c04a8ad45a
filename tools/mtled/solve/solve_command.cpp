#include "mtled/solve/solve_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "approximation/shape_functions.h"
#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/key.h"
#include "discretization/surface/surface_tree.h"
#include "io/csv_table.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/probes_file.h"
#include "io/result_csv.h"
#include "io/scene_file.h"
#include "io/vtu_file.h"
#include "mtled/run/checkpoint.h"
#include "mtled/run/progress.h"
#include "simulation/model_hash.h"
#include "simulation/scene_messages.h"
#include "simulation/solution_fields.h"
#include "simulation/static_solver.h"
#include "simulation/transient_solver.h"

namespace palpate::tools {
namespace {

using Seconds = std::chrono::duration<double>;

/// Time after which nothing moves any more, s.
double endTime(const Scene& scene, const std::optional<ToolScript>& script) {
  if (scene.solve.end_time > 0) return scene.solve.end_time;
  double end = script ? script->duration() : 0;
  for (const auto& b : scene.boundaries)
    end = std::max({end, b.duration, b.curve.time.empty() ? 0 : b.curve.time.back()});
  if (end <= 0 && !scene.gravity.isZero(0)) return 1;  // the weight is there from the start
  if (end <= 0)
    throw InputError(scene.solve.place.file.empty() ? scene.place : scene.solve.place,
                     "nothing moves in this scene, so there is no time to solve to",
                     "add a [[prescribed]] motion or --tool SCRIPT, or set end_time in [solve]");
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
double ticksTo(double end, const Scene& scene) { return std::max(1.0, std::ceil(end / (1 / scene.rate_hz) - 1e-9)); }

/// A motion that would fill every disk with its force curve is a typing error.
void checkLength(const Scene& scene, double end) {
  constexpr double max_ticks = 1e8;
  if (scene.solve.mode != SolveSpec::Mode::Transient || ticksTo(end, scene) <= max_ticks) return;
  const std::string advice = "a transient solution can have 1e8, " + number(max_ticks / scene.rate_hz) + " s; ";
  throw InputError(scene.places.contains("solve.end_time") ? placeOf(scene, "solve.end_time")
                   : scene.solve.place.file.empty()        ? scene.place
                                                           : scene.solve.place,
                   "the motion to " + number(end) + " s has " + number(ticksTo(end, scene)) + " ticks",
                   advice + (scene.solve.end_time > 0 ? "lower end_time" : "set end_time in [solve]"));
}

/// Of all that decides a solution: what a checkpoint must agree in.
std::uint64_t identityOf(const Model& model, const std::optional<ToolScript>& script, double end) {
  ByteKey key;
  key.add(modelHash(model), model.scene.solve.mode);
  // What a load step is; more of the same may follow.
  if (model.scene.solve.mode == SolveSpec::Mode::Static) key.add(end / model.scene.solve.load_steps);
  if (script) {
    key.add(script->from_touch, script->smooth);
    for (const auto& k : script->keyframes) key.add(k.time, k.advance, k.slide);
  }
  return key.hash();
}

/// Everything that a solution leaves in its folder.
class Results {
 public:
  /// @param identity  hash of model and load: what a checkpoint must have been made with
  Results(const Model& model, const std::string& folder, double end, std::uint64_t identity, bool resume)
      : model_(model), folder_(folder), end_(end) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw std::runtime_error(folder + ": " + error.message());
    if (!model.scene.solve.probes_file.empty()) {
      const auto place = model.scene.places.find("solve.probes");
      probes_ = readProbes(model.scene.solve.probes_file,
                           place == model.scene.places.end() ? SourceLocation{} : place->second);
      const Neighbours neighbours(model.X, model.support_radius);
      std::vector<InadmissibleSupport> failed;
      probe_shape_ = shapeFunctions(probes_.X, model.X, model.support_radius, neighbours,
                                    {model.scene.basis_degree, model.scene.mmls_weight}, failed);
      const SurfaceTree organ(organSurface(model.scene));
      // The organ's faces are flat where a probe may lie on the round that they stand for.
      const double tolerance = 0.05 * model.scene.spacing;
      for (std::size_t k = 0; k < probes_.X.size(); ++k)
        if (organ.signedDistance(probes_.X[k]) > tolerance)
          throw InputError({model.scene.solve.probes_file, probes_.table.line[k]}, "this point lies outside the body",
                           "move it inside, or leave it out");
      if (!failed.empty())
        throw InputError({model.scene.solve.probes_file, probes_.table.line[failed.front().row]},
                         "the nodes near this point can't carry an approximation", "move it inwards, or leave it out");
    }
    std::vector<std::string> columns{"time_s", "iterations", "min_J", "inverted_points"};
    for (const auto& b : model.scene.boundaries)
      for (const char* part : {"_fx_N", "_fy_N", "_fz_N", "_mx_Nm", "_my_Nm", "_mz_Nm"})
        columns.push_back(b.name + part);
    for (const char* part : {"tool_fx_N", "tool_fy_N", "tool_fz_N"}) columns.emplace_back(part);
    if (model.scene.skull.given)
      for (const char* part : {"skull_fx_N", "skull_fy_N", "skull_fz_N", "skull_penetration_m"})
        columns.emplace_back(part);
    if (model.scene.solve.mode == SolveSpec::Mode::Static)
      columns.emplace_back("error_m");  // a motion has no such estimate
    std::vector<std::vector<double>> kept;
    if (resume) {
      checkpoint_ = readCheckpoint(checkpointFile(), identity, model.X.size());
      const CsvTable earlier = readCsvTable(forceFile());
      if (earlier.name != columns || static_cast<std::int64_t>(earlier.rowCount()) < checkpoint_.rows)
        throw InputError({forceFile()}, "this file does not belong to the checkpoint", "start without --resume");
      for (std::int64_t r = 0; r < checkpoint_.rows; ++r) {
        kept.emplace_back();
        for (const auto& column : earlier.column) kept.back().push_back(column[static_cast<std::size_t>(r)]);
      }
      if (!kept.empty()) {
        last_row_ = kept.back();
        const double* at = last_row_.data() + first_reaction;
        for (std::size_t b = 0; b < model.scene.boundaries.size(); ++b, at += 6)
          last_reactions_.push_back({Vec3(at[0], at[1], at[2]), Vec3(at[3], at[4], at[5])});
      }
    } else {
      checkpoint_.model_hash = identity;
      checkpoint_.u.resize(model.X.size());
      checkpoint_.du.resize(model.X.size());
    }
    force_ = std::make_unique<ResultCsv>(forceFile(), columns);
    for (const auto& row : kept) force_->add(row);
    // Nothing can be refused any more: what an earlier run left gives way.
    if (!resume) std::filesystem::remove(checkpointFile(), error);
    force_->takePlace();
    for (std::size_t k = 0; k < checkpoint_.frame_time.size(); ++k)
      pvd_.push_back({checkpoint_.frame_time[k], frameName(k)});
  }

  const Checkpoint& checkpoint() const { return checkpoint_; }
  /// Throws where the checkpoint remembers other than a solver does.
  void checkHistory(const AlignedVector<double>& solver) const {
    if (checkpoint_.history.size() != solver.size())
      throw InputError({checkpointFile()}, "the checkpoint is damaged", "start without --resume");
  }
  double error() const { return last_row_.empty() ? 0 : last_row_.back(); }  // m, of the last equilibrium

  /// One equilibrium or tick, with a frame when its time has come. @param position  for a resumed run
  /// @param error  m, of an equilibrium
  void add(std::int64_t position, double time, std::optional<double> error, int iterations, double min_J, int inverted,
           const BatchBody& body, const Vec3& tool_force, const SkullContact& skull, double largest = 0) {
    std::vector<double> row{time, static_cast<double>(iterations), min_J, static_cast<double>(inverted)};
    for (const auto& r : body.reactions())
      for (const Vec3& v : {r.force, r.moment}) row.insert(row.end(), v.data(), v.data() + 3);
    row.insert(row.end(), tool_force.data(), tool_force.data() + 3);
    if (model_.scene.skull.given) {
      row.insert(row.end(), skull.force.data(), skull.force.data() + 3);
      row.push_back(skull.max_penetration);
      last_skull_ = skull;
    }
    if (error) row.push_back(*error);
    force_->add(row);
    ++checkpoint_.rows;
    checkpoint_.position = position;
    checkpoint_.largest = largest;
    checkpoint_.u = body.u;
    checkpoint_.du = body.du;
    checkpoint_.history = body.history();
    last_reactions_ = body.reactions();
    last_row_ = std::move(row);
    const int frames = model_.scene.solve.frames;
    if (time >= end_ * static_cast<double>(checkpoint_.frame_time.size() + 1) / frames * (1 - 1e-9))
      addFrame(time, body);
    if (Clock::now() - saved_ > std::chrono::seconds(10)) save();
  }

  /// Probes, checkpoint and report of the last row. @param outcome  more members of the report
  void finish(nlohmann::json outcome) {
    force_->finish();
    save();
    if (!probes_.X.empty()) {
      ResultCsv csv(folder_ + "/probes.csv", {"X", "Y", "Z", "ux", "uy", "uz"});
      const auto u = fieldAt(probe_shape_, checkpoint_.u);
      for (std::size_t k = 0; k < u.size(); ++k)
        csv.add(
            std::vector<double>{probes_.X[k].x(), probes_.X[k].y(), probes_.X[k].z(), u[k].x(), u[k].y(), u[k].z()});
      csv.finish();
    }
    nlohmann::json reactions;
    for (std::size_t b = 0; b < last_reactions_.size(); ++b) {
      const auto& r = last_reactions_[b];
      reactions[model_.scene.boundaries[b].name] = {{"force_N", {r.force.x(), r.force.y(), r.force.z()}},
                                                    {"moment_Nm", {r.moment.x(), r.moment.y(), r.moment.z()}}};
    }
    outcome.update({{"scene", model_.scene.name},
                    {"nodes", model_.nodeCount()},
                    {"integration_points", model_.pointCount()},
                    {"mean_support", model_.point_shape.meanSupport()},
                    {"rows", checkpoint_.rows},
                    {"frames", checkpoint_.frame_time.size()},
                    {"reactions", reactions},
                    {"setup_seconds", model_.setup_seconds},
                    {"build", buildInfo()}});
    if (last_skull_) {
      const Vec3& f = last_skull_->force;
      outcome["skull"] = {{"force_N", {f.x(), f.y(), f.z()}}, {"max_penetration_m", last_skull_->max_penetration}};
    }
    if (!last_row_.empty()) {
      outcome["time_s"] = last_row_[0];
      outcome["min_J"] = last_row_[2];
      outcome["inverted_points"] = static_cast<int>(last_row_[3]);
    }
    writeWholeFile(folder_ + "/report.json",
                   outcome.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }

  void print() const {
    std::cout << "force curve  " << forceFile() << "\nParaView     " << folder_ << "/solution.pvd\nreport       "
              << folder_ << "/report.json\n";
    if (!probes_.X.empty()) std::cout << "probes       " << folder_ << "/probes.csv\n";
    std::cout.flush();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t first_reaction = 4;  // its column

  std::string forceFile() const { return folder_ + "/force.csv"; }
  std::string checkpointFile() const { return folder_ + "/checkpoint.bin"; }
  static std::string frameName(std::size_t k) {
    char name[32];
    std::snprintf(name, sizeof name, "solution_%04d.vtu", static_cast<int>(k));
    return name;
  }
  void addFrame(double time, const BatchBody& body) {
    std::vector<Vec3> u;
    for (const auto& a : body.u) u.push_back(toVec3(a));
    const SolutionFields fields = solutionFields(model_, u, body.pointHistory());
    std::vector<Vec3> reaction(model_.X.size(), Vec3::Zero());
    body.addNodeReactions(reaction);
    const std::vector<VtuField> at_nodes{vtuVectors("displacement_m", fields.displacement),
                                         vtuVectors("reaction_N", reaction)};
    const std::vector<VtuField> in_cells{
        {"J", fields.J}, {"von_Mises_Pa", fields.von_mises}, {"pressure_Pa", fields.pressure}};
    const std::string name = frameName(checkpoint_.frame_time.size());
    writeVtu(folder_ + "/" + name, model_.X, model_.cells, at_nodes, in_cells);
    pvd_.push_back({time, name});
    writePvd(folder_ + "/solution.pvd", pvd_);
    checkpoint_.frame_time.push_back(time);
  }

  void save() {
    writeCheckpoint(checkpointFile(), checkpoint_);
    saved_ = Clock::now();
  }

  const Model& model_;
  std::string folder_;
  double end_;
  Probes probes_;
  ShapeTable probe_shape_;
  std::unique_ptr<ResultCsv> force_;
  std::vector<double> last_row_;
  std::vector<Reaction> last_reactions_;
  std::optional<SkullContact> last_skull_;  // of this run
  std::vector<PvdFrame> pvd_;
  Checkpoint checkpoint_;
  Clock::time_point saved_ = Clock::now();
};

struct Task {
  const Model& model;
  const std::optional<ToolScript>& script;
  double end;
  int threads;
  bool resume;

  std::optional<Pose> tool(double time) const {
    if (!script) return {};
    return poseAt(*script, model.tool_start, model.first_contact_travel, time);
  }
};

int solveStatic(const Task& task, Results& results) {
  const auto start = std::chrono::steady_clock::now();
  const SolveSpec& spec = task.model.scene.solve;
  StaticSolver solver(task.model, task.threads, spec.tolerance);
  if (task.resume)
    solver.resume(task.end * static_cast<double>(results.checkpoint().position) / spec.load_steps,
                  results.checkpoint().u,
                  task.tool(task.end * static_cast<double>(results.checkpoint().position) / spec.load_steps),
                  results.checkpoint().largest);
  ProgressLine progress("solve");
  int iterations = 0;
  Equilibrium e;
  e.converged = true;
  for (std::int64_t k = results.checkpoint().position + 1; k <= spec.load_steps; ++k) {
    const auto watch = [&](int of_step) {
      // A load step takes a few hundred iterations; the bar moves within it, and never past it.
      const double within = 1 - std::exp(-of_step / 400.0);
      progress.show((k - 1 + within) / spec.load_steps, "load step " + std::to_string(k) + " of " +
                                                            std::to_string(spec.load_steps) + ", iteration " +
                                                            std::to_string(of_step));
      return !interrupted();
    };
    const double time = task.end * k / spec.load_steps;
    e = solver.advanceTo(time, task.tool(time), watch);
    iterations += e.iterations;
    if (!e.converged) break;
    results.add(k, time, e.error, e.iterations, e.min_J, e.inverted_points, solver.body(), e.tool_force, e.skull,
                solver.largestSoFar());
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
    std::cerr << "mtled: no equilibrium within the tolerance at " << e.time << " s after "
              << StaticSolver::max_iterations << " iterations; the results end before it\n";
  }
  if (e.interrupted) std::cerr << "mtled: interrupted; --resume goes on from the last load step\n";
  return e.converged && !e.diverged && !e.interrupted ? 0 : 1;
}

int solveTransient(const Task& task, Results& results) {
  const auto start = std::chrono::steady_clock::now();
  TransientSolver solver(task.model, task.threads);
  if (task.resume) results.checkHistory(solver.body().history());
  if (task.resume)
    solver.resume(results.checkpoint().position, results.checkpoint().u, results.checkpoint().du,
                  task.tool(static_cast<double>(results.checkpoint().position) * task.model.dt),
                  results.checkpoint().history);
  ProgressLine progress("solve");
  const double tick = 1 / task.model.scene.rate_hz;
  const auto ticks = static_cast<std::int64_t>(ticksTo(task.end, task.model.scene));
  bool stopped = false, diverged = false;
  for (std::int64_t k = solver.step() / task.model.substeps_per_tick + 1; k <= ticks && !stopped && !diverged; ++k) {
    const auto report = solver.tick(task.tool(static_cast<double>(k) * tick), [] { return !interrupted(); });
    stopped = !report;
    if (stopped) break;
    diverged = !report->finite || report->max_increment > task.model.max_increment;
    if (!diverged)
      results.add(solver.step(), solver.time(), {}, task.model.substeps_per_tick, report->min_J,
                  report->inverted_points, solver.body(), report->tool_force, report->skull);
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
                  {"added_mass", task.model.added_mass},
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
  if (const std::vector<ToolSpec> tools = toolsOf(scene); tools.size() > 1 || tools[0].jaws())
    throw InputError(tools.back().place, "mtled solve moves a single tool, and no jaws",
                     "leave the others and \"opening\" out, or run the scene with palpate --offscreen");
  const std::optional<ToolScript> script = namedScript(options.tool_script, scene.tool.radius);
  const double end = endTime(scene, script);
  checkLength(scene, end);
  std::unique_ptr<Model> model;
  {
    ProgressLine progress("set-up");
    const ModelCache cache(options.use_cache ? ModelCache::userFolder() : "", warn);
    const auto show = [&](const std::string& what, double fraction) {
      if (interrupted()) throw std::runtime_error("interrupted while the model was made");
      progress.show(fraction, what);
    };
    model = std::make_unique<Model>(loadModel(scene, show, cache, warn));
  }
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Results results(*model, options.out.empty() ? usualFolder(options, file) : options.out, end,
                  identityOf(*model, script, end), options.resume);
  std::cout << scene.name << ": " << model->nodeCount() << " nodes, " << model->pointCount()
            << " integration points, set up in " << model->setup_seconds << " s" << std::endl;
  const Task task{*model, script, end, options.threads > 0 ? options.threads : cores, options.resume};
  const int code =
      scene.solve.mode == SolveSpec::Mode::Static ? solveStatic(task, results) : solveTransient(task, results);
  results.print();
  return code;
}

AlignedVector<Double4> solutionOf(const Model& model, const std::string& folder) {
  const std::string file = (std::filesystem::path(folder) / "checkpoint.bin").string();
  const std::uint64_t identity = identityOf(model, {}, endTime(model.scene, {}));
  const Checkpoint checkpoint = readCheckpoint(file, identity, model.X.size());
  if (model.scene.solve.mode == SolveSpec::Mode::Static && checkpoint.position < model.scene.solve.load_steps)
    warn(file + ": the solution ends before the last load step");
  return checkpoint.u;
}

}  // namespace palpate::tools

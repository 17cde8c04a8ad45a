#include "mtled/fit_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/indent_script.h"
#include "app/interrupt.h"
#include "app/options.h"
#include "base/build_info.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_edit.h"
#include "io/scene_file.h"
#include "mtled/fit_search.h"
#include "mtled/progress.h"
#include "mtled/rate_check.h"

namespace palpate {
namespace {

constexpr int probe_count = 200;
// Of a tick for its median: the 99.9th percentile is a fifth to a quarter above it.
constexpr double median_share = 0.72;
constexpr double check_seconds = 4;
constexpr int most_checks = 4;

std::string shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// The scene file with what was fitted, its paths made to fit the new place. Throws InputError where the file's layout
/// hides a key from the editor.
std::string fittedText(const std::string& scene_file, const Scene& given, const Scene& fitted, const std::string& to) {
  std::ifstream in(scene_file, std::ios::binary);
  std::stringstream read;
  read << in.rdbuf();
  std::string text = read.str();
  const auto folder = std::filesystem::absolute(to).parent_path();
  const auto pathFrom = [&](const std::string& path) {
    return "\"" + std::filesystem::proximate(std::filesystem::absolute(path), folder).generic_string() + "\"";
  };
  if (given.solid == Scene::Solid::Surface) text = withSceneKey(text, "organ", "surface", pathFrom(given.surface_file));
  if (!given.solve.probes_file.empty()) text = withSceneKey(text, "solve", "probes", pathFrom(given.solve.probes_file));
  text = withSceneKey(text, "discretization", "spacing", shortest(fitted.spacing));
  text = withSceneKey(text, "discretization", "support_factor", shortest(fitted.support_factor));
  text = withSceneKey(text, "discretization", "points_per_cell", std::to_string(fitted.quadrature.points_per_cell));
  text = withSceneKey(text, "discretization", "consistent_gradients", "true");
  text = withSceneKey(text, "discretization", "node_patch_volume", "true");
  text = withSceneKey(text, "dynamics", "rate", shortest(fitted.rate_hz));
  text = withSceneKey(text, "dynamics", "time_step", "0");
  text = withSceneKey(text, "dynamics", "threads", std::to_string(fitted.threads));
  return text;
}

/// Whether a scene says what was fitted.
bool says(const Scene& scene, const Scene& fitted) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-5 * std::abs(b); };
  return near(scene.spacing, fitted.spacing) && near(scene.support_factor, fitted.support_factor) && near(scene.rate_hz, fitted.rate_hz) &&
         scene.threads == fitted.threads && scene.quadrature.accuracy == 0 &&
         scene.quadrature.points_per_cell == fitted.quadrature.points_per_cell;
}

}  // namespace

int fitCommand(const FitOptions& options) {
  const std::string scene_file = findScene(options.scene, std::string(PALPATE_SOURCE_DIR) + "/assets/scenes");
  const Scene given = readScene(scene_file);
  if (!given.refine.empty())
    throw InputError(given.refine.front().place, "`mtled fit` chooses one spacing for the whole organ", "leave the refinements out");
  if (given.quadrature.accuracy > 0)
    throw InputError(given.place, "`mtled fit` uses one point a cell", "leave quadrature_accuracy out");
  Scene scene = given;
  if (options.rate_hz > 0) scene.rate_hz = options.rate_hz;
  scene.threads = options.cores > 0 ? options.cores : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const std::string out = options.out.empty() ? "out/" + std::filesystem::path(scene_file).stem().string() + "_" + shortest(scene.rate_hz) + "hz.toml" : options.out;
  if (std::filesystem::exists(out) && std::filesystem::equivalent(out, scene_file))
    throw InputError({out}, "this is the scene itself", "give another --out");
  const auto parent = std::filesystem::absolute(out).parent_path();
  std::error_code problem;
  std::filesystem::create_directories(parent, problem);
  if (problem) throw std::runtime_error(parent.string() + ": " + problem.message());

  ProgressLine progress("fit");
  progress.show(0, "set-up");
  const Model present = loadModel(scene);
  const ToolWay way = options.tool_script.empty() ? indentationWay(present)
                                                  : scriptPoses(readToolScript(options.tool_script, scene.tool.radius), present);
  const auto probes = surfaceProbes(present, probe_count);
  const auto families = fitFamilies(scene);
  std::vector<FitCandidate> candidates;
  for (std::size_t k = 0; k < families.size(); ++k) {
    const FitTask task{scene, way, probes, scene.threads, [&](double fraction, const std::string& what) {
                         progress.show(0.5 * (static_cast<double>(k) + fraction) / static_cast<double>(families.size()), what);
                       }};
    FitCandidate c = finestWithin(task, families[k], median_share);
    if (c.spacing_factor > 0) candidates.push_back(std::move(c));
  }
  if (interrupted()) throw std::runtime_error("interrupted; nothing is written");
  if (candidates.empty()) {
    std::cerr << "mtled: no setting of this scene holds " << scene.rate_hz << " Hz with " << scene.threads << " threads on this machine\n";
    return 1;
  }

  // Finer than the finest candidate.
  double finest = candidates.front().spacing_factor;
  for (const auto& c : candidates) finest = std::min(finest, c.spacing_factor);
  const WorkedOn place = workedOn(present, way);
  const Fineness fineness = fitFineness(finest);
  const ConvergedRun converged = convergedRun(present, way, probes, place, fineness, scene.threads,
                                              [&](double fraction, const std::string& what) { progress.show(0.5 + 0.3 * fraction, what); });
  for (auto& c : candidates) {
    c.error = errorOf(c.run, converged.run);
    c.expected_error = expectedError(c.error, converged, fineness.coarser);
  }
  FitCandidate chosen = *std::min_element(candidates.begin(), candidates.end(),
                                          [](const auto& a, const auto& b) { return a.expected_error < b.expected_error; });

  // In the real-time loop, where the rest of the machine has its say: coarser until it holds.
  HeldRate held;
  bool holds = false;
  for (int attempt = 0; attempt < most_checks && !holds && !interrupted(); ++attempt) {
    progress.show(0.8 + 0.05 * attempt, "in the real-time loop");
    Model model = loadModel(chosen.scene);
    held = checkRate(model, way, scene.threads, check_seconds);
    holds = held.held(scene.rate_hz);
    if (holds) break;
    scaleSpacing(chosen.scene, 1.06);
    const Model coarser = loadModel(chosen.scene);
    chosen.nodes = coarser.nodeCount();
    chosen.points = coarser.pointCount();
    chosen.substeps = coarser.substeps_per_tick;
    chosen.run = runWay(coarser, way, probes, scene.threads);
    chosen.error = errorOf(chosen.run, converged.run);
    chosen.expected_error = expectedError(chosen.error, converged, fineness.coarser);
  }
  if (interrupted()) throw std::runtime_error("interrupted; nothing is written");
  if (!holds) {
    std::cerr << "mtled: " << scene.rate_hz << " Hz are not held in the real-time loop: " << held.overruns << " of " << held.ticks + held.overruns
              << " periods missed, p99.9 " << held.step_us.p999 << " us. Is another program busy?\n";
    return 1;
  }
  progress.show(1, "done");

  writeWholeFile(out, fittedText(scene_file, given, chosen.scene, out));
  if (!says(readScene(out), chosen.scene))
    throw InputError({out}, "this scene file's layout keeps `mtled fit` from changing it",
                     "write spacing, support_factor and points_per_cell into a [discretization] table, rate, time_step and threads into [dynamics]");
  const double headroom = 1 - held.step_us.p999 * 1e-6 * scene.rate_hz;
  std::printf("%s at %g Hz on %d threads: %d nodes, %d points, %d steps a tick, %s\n", given.name.c_str(), scene.rate_hz, scene.threads,
              chosen.nodes, chosen.points, chosen.substeps, chosen.family.c_str());
  std::printf("  expected force error   %.2f %% of the largest force (%.2f %% from a solution with %d nodes)\n", 100 * chosen.expected_error,
              100 * chosen.error.force, converged.about.nodes);
  std::printf("  headroom               %.0f %% of a tick at p99.9 (%.0f of %.0f us), %lld of %lld periods missed\n", 100 * headroom,
              held.step_us.p999, 1e6 / scene.rate_hz, static_cast<long long>(held.overruns), static_cast<long long>(held.ticks + held.overruns));
  std::printf("  scene                  %s\n", out.c_str());
  if (!options.json.empty()) {
    const nlohmann::ordered_json json = {{"scene", given.name}, {"file", out}, {"rate_hz", scene.rate_hz}, {"threads", scene.threads}, {"family", chosen.family},
                                         {"spacing_m", chosen.scene.spacing}, {"nodes", chosen.nodes}, {"points", chosen.points}, {"substeps", chosen.substeps},
                                         {"expected_force_error", chosen.expected_error}, {"distance_from_reference", chosen.error.force},
                                         {"reference_nodes", converged.about.nodes}, {"tick_p999_us", held.step_us.p999}, {"headroom", headroom},
                                         {"overruns", held.overruns}, {"ticks", held.ticks}, {"realtime_factor", held.realtime_factor}, {"build", buildInfo()}};
    writeWholeFile(options.json, json.dump(2) + "\n");
  }
  return 0;
}

}  // namespace palpate

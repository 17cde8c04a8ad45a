#include "mtled/fit/fit_command.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "base/parallel_for.h"
#include "io/find_asset.h"
#include "io/indent_script.h"
#include "io/load_model.h"
#include "io/output_file.h"
#include "io/scene_edit.h"
#include "io/scene_file.h"
#include "io/text_file.h"
#include "mtled/fit/fit_search.h"
#include "mtled/fit/rate_check.h"
#include "mtled/run/progress.h"
#include "setup/place.h"

namespace palpate::tools {
namespace {

constexpr int probe_count = 200;
// Of a tick for its median: the 99.9th percentile is a fifth to a quarter above it.
constexpr double median_share = 0.72;
constexpr double check_seconds = 4;
constexpr int max_checks = 4;

/// m, as the file has it.
double writtenSpacing(const Scene& fitted) {
  return fitted.discretization.follow ? fineSpacing(fitted) : fitted.discretization.spacing;
}

/// A scene file's text with what was fitted, its paths made to fit the new place.
std::string fittedText(std::string text, const Scene& given, const Scene& fitted, const std::string& to) {
  const auto folder = std::filesystem::absolute(to).parent_path();
  const auto pathFrom = [&](const std::string& path) {
    std::string value = "\"";
    value.append(std::filesystem::proximate(std::filesystem::absolute(path), folder).generic_string()).append("\"");
    return value;
  };
  if (given.organs[0].solid == OrganSpec::Solid::Surface)
    text = withSceneKey(text, "organ", "surface", pathFrom(given.organs[0].surface_file));
  if (!given.solve.probes_file.empty()) text = withSceneKey(text, "solve", "probes", pathFrom(given.solve.probes_file));
  text = withSceneKey(text, "discretization", "spacing", format("%.6g", writtenSpacing(fitted)));
  if (fitted.discretization.follow) {
    text = withSceneKey(text, "discretization", "follow", "true");
  } else {
    text = withSceneKey(text, "discretization", "support_factor", format("%.6g", fitted.discretization.support_factor));
    text = withSceneKey(text, "discretization", "points_per_cell",
                        std::to_string(fitted.discretization.quadrature.points_per_cell));
    text = withSceneKey(text, "discretization", "cells_per_point",
                        format("%.6g", fitted.discretization.quadrature.cells_per_point));
  }
  if (given.discretization.formulation != fitted.discretization.formulation)
    text = withSceneKey(text, "discretization", "scheme", "\"standard\"");
  if (!fitted.discretization.follow && !fitted.discretization.refine.empty()) {
    std::string refine;
    for (const auto& r : fitted.discretization.refine)
      refine += (refine.empty() ? "[{ centre = [" : ", { centre = [") + format("%.6g", r.centre.x()) + ", " +
                format("%.6g", r.centre.y()) + ", " + format("%.6g", r.centre.z()) +
                "], radius = " + format("%.6g", r.radius) + ", spacing = " + format("%.6g", r.spacing) + " }";
    text = withSceneKey(text, "discretization", "refine", refine + "]");
  }
  text = withSceneKey(text, "dynamics", "rate", format("%.6g", fitted.dynamics.rate_hz));
  text = withSceneKey(text, "dynamics", "time_step", "0");
  if (fitted.dynamics.mass_scaling != given.dynamics.mass_scaling)
    text = withSceneKey(text, "dynamics", "mass_scaling", format("%.6g", fitted.dynamics.mass_scaling));
  text = withSceneKey(text, "dynamics", "threads", std::to_string(fitted.dynamics.threads));
  return text;
}

/// Whether a scene says what was fitted.
bool says(const Scene& scene, const Scene& fitted) {
  const auto near = [](double a, double b) { return std::abs(a - b) <= 1e-5 * std::abs(b); };
  return scene.discretization.follow == fitted.discretization.follow &&
         near(writtenSpacing(scene), writtenSpacing(fitted)) &&
         near(scene.discretization.support_factor, fitted.discretization.support_factor) &&
         near(scene.dynamics.rate_hz, fitted.dynamics.rate_hz) && scene.dynamics.threads == fitted.dynamics.threads &&
         scene.dynamics.mass_scaling == fitted.dynamics.mass_scaling && scene.discretization.quadrature.accuracy == 0 &&
         scene.discretization.quadrature.points_per_cell == fitted.discretization.quadrature.points_per_cell &&
         scene.discretization.quadrature.cells_per_point == fitted.discretization.quadrature.cells_per_point &&
         std::equal(scene.discretization.refine.begin(), scene.discretization.refine.end(),
                    fitted.discretization.refine.begin(), fitted.discretization.refine.end(),
                    [&](const RefineSpec& a, const RefineSpec& b) {
                      return near(a.spacing, b.spacing) && near(a.radius, b.radius) &&
                             (a.centre - b.centre).norm() <= 1e-4 * b.radius;
                    });
}

void stopIfInterrupted() {
  if (interrupted()) throw std::runtime_error("interrupted");
}

/// What is to be fitted, checked, and where it is to go.
struct FitOrder {
  std::string scene_file, out, stem;
  Scene given, scene;  // as it is; with the rate and the threads that are asked for
  std::optional<ToolScript> script;
};

Scene sceneIn(const std::string& text, const std::string& to) {
  return readScene(SceneText{text, std::filesystem::absolute(to).parent_path().string(), to});
}

/// The scene file to be written, which can be read. Throws InputError where there is none.
std::string textFor(const FitOrder& order, const Scene& fitted) {
  const std::string text = readWholeFile(order.scene_file);
  try {
    const std::string edited = fittedText(text, order.given, fitted, order.out);
    sceneIn(edited, order.out);
    return edited;
  } catch (const InputError&) {  // tables without headers
  }
  try {
    const std::string edited = fittedText(withHeaders(text, order.scene_file), order.given, fitted, order.out);
    sceneIn(edited, order.out);
    return edited;
  } catch (const InputError& error) {
    throw InputError({order.scene_file}, std::string("no fitted scene can be written from it: ") + error.what(),
                     "where it names files, write beside it, with --out");
  }
}

FitOrder orderOf(const FitOptions& options) {
  FitOrder order;
  order.scene_file = findScene(options.scene);
  order.given = readScene(order.scene_file);
  const Scene& given = order.given;
  const bool follows = given.discretization.follow;
  if (!follows && !given.discretization.refine.empty())
    throw InputError(given.discretization.refine.front().place,
                     "`mtled fit` chooses the spacing and where it is finer itself", "leave the refinements out");
  if (given.discretization.quadrature.accuracy > 0)
    throw InputError(given.place, "`mtled fit` chooses the points itself", "leave quadrature_accuracy out");
  order.script = namedScript(options.tool_script, given.tools[0].shape.radius);
  order.scene = given;
  if (options.rate_hz > 0) order.scene.dynamics.rate_hz = options.rate_hz;
  const int cores = threadsOr(options.cores);
  // A core is left to the worker that makes places.
  order.scene.dynamics.threads = follows ? std::max(1, cores - 1) : cores;
  order.out = options.out.empty() ? "out/" + std::filesystem::path(order.scene_file).stem().string() + "_" +
                                        format("%.6g", order.scene.dynamics.rate_hz) + "hz.toml"
                                  : options.out;
  if (std::filesystem::exists(order.out) && std::filesystem::equivalent(order.out, order.scene_file))
    throw InputError({order.out}, "this is the scene itself", "give another --out");
  textFor(order, order.scene);  // what can't be written is told before the search
  order.stem = std::filesystem::path(order.out).replace_extension().string();
  makeFolder(std::filesystem::absolute(order.out).parent_path().string());
  return order;
}

/// What is known of the way that the tool goes.
struct FitWay {
  const Model& present;
  ToolTrajectory way;
  std::vector<Vec3> probes;
};

/// The finest setting of each family that holds the rate.
std::vector<FitCandidate> finestOfEach(FitTask& task, const std::vector<FitFamily>& families, ProgressLine& progress) {
  std::vector<FitCandidate> candidates;
  double start = 1;
  for (std::size_t k = 0; k < families.size(); ++k) {
    task.watch = [&](double fraction, const std::string& what) {
      progress.show(0.6 * (static_cast<double>(k) + fraction) / static_cast<double>(families.size()), what);
    };
    // Finer nodes where the tool works take time from the others.
    FitCandidate c = finestWithin(task, families[k], median_share, families[k].inside < 1 ? 1.1 * start : 1);
    if (c.spacing_factor == 0) continue;
    if (k == 0) start = c.spacing_factor;
    candidates.push_back(std::move(c));
  }
  task.watch = [](double, const std::string&) {};
  return candidates;
}

/// Finer than the finest candidate.
/// @param present  the scene as it is; of a cloud that follows, the place at which its tool starts
Fineness finerThan(const std::vector<FitCandidate>& candidates, const Model& present) {
  double outside = INFINITY, inside = INFINITY;
  for (const auto& c : candidates) {
    const Scene& scene = c.scene;
    outside = std::min(outside, c.spacing_factor);
    inside = std::min(inside, scene.discretization.follow ? fineSpacing(scene) / present.scene.discretization.spacing
                                                          : c.spacing_factor * c.inside);
  }
  return fitFineness(outside, inside);
}

ConvergedRun referenceRun(const FitOptions& options, const FitOrder& order, const FitWay& w, const Fineness& fineness,
                          ProgressLine& progress) {
  const std::string file = order.stem + ".reference.json",
                    identity = runIdentity(w.present, w.way, {fineness.outside, fineness.inside});
  ConvergedRun converged;
  if (options.resume && readConvergedRun(file, identity, converged)) return converged;
  converged =
      convergedRun(w.present, w.way, w.probes, contactRegions(w.present, w.way), fineness, order.scene.dynamics.threads,
                   [&](double fraction, const std::string& what) { progress.show(0.6 + 0.3 * fraction, what); });
  writeConvergedRun(file, converged, identity);
  return converged;
}

/// In the real-time loop, where the rest of the machine has its say: of those that are left the most exact, until one
/// holds. One that does not leaves a coarser one of its family.
/// @param chosen  receives what was tried last
HeldRate heldInTheLoop(FitTask& task, const std::vector<FitFamily>& families, const ConvergedRun& converged,
                       const Fineness& fineness, std::vector<FitCandidate> left, FitCandidate& chosen,
                       ProgressLine& progress) {
  HeldRate held;
  for (int attempt = 0; attempt < max_checks && !left.empty() && !interrupted(); ++attempt) {
    progress.show(0.9 + 0.02 * attempt, "in the real-time loop");
    const auto best = std::min_element(left.begin(), left.end(), [](const FitCandidate& a, const FitCandidate& b) {
      return a.expected.force < b.expected.force;
    });
    chosen = std::move(*best);
    left.erase(best);
    held = checkRate(chosen.scene, task.way, task.threads, check_seconds);
    if (held.held(task.scene.dynamics.rate_hz)) break;
    const auto family =
        std::find_if(families.begin(), families.end(), [&](const FitFamily& f) { return f.name == chosen.family; });
    FitCandidate coarser = tried(task, *family, 1.06 * chosen.spacing_factor);
    if (coarser.nodes == 0 || coarser.run.interrupted) continue;
    coarser.error = errorOf(coarser.run, converged.run);
    coarser.expected = expectedError(coarser.error, converged, fineness.coarser);
    left.push_back(std::move(coarser));
  }
  return held;
}

/// What is told of the scene that was written.
struct Fitted {
  const FitOrder& order;
  const FitCandidate& chosen;
  const std::vector<FitCandidate>& candidates;
  const HeldRate& held;
  int reference_nodes;

  double headroom() const { return 1 - held.step_us.p999 * 1e-6 * order.scene.dynamics.rate_hz; }
};

void printFitted(const Fitted& f) {
  std::printf("%s at %g Hz on %d threads: %d nodes, %d points, %d steps a tick, %s\n", f.order.given.name.c_str(),
              f.order.scene.dynamics.rate_hz, f.order.scene.dynamics.threads, f.chosen.nodes, f.chosen.points,
              f.chosen.substeps, f.chosen.family.c_str());
  std::printf(
      "  expected force error   up to %.2f %% of the force, from half of the largest on; as a root mean square over "
      "the "
      "way %.2f %% of the largest (%.2f and %.2f %% from a solution with %d nodes)\n",
      100 * f.chosen.expected.loaded, 100 * f.chosen.expected.force, 100 * f.chosen.error.loaded,
      100 * f.chosen.error.force, f.reference_nodes);
  std::printf("  headroom               %.0f %% of a tick at p99.9 (%.0f of %.0f us), %lld of %lld periods missed\n",
              100 * f.headroom(), f.held.step_us.p999, 1e6 / f.order.scene.dynamics.rate_hz,
              static_cast<long long>(f.held.overruns), static_cast<long long>(f.held.ticks) + f.held.overruns);
  if (f.chosen.scene.discretization.follow)
    std::printf("  nodes                  %.3g mm apart near the tool, which they follow\n",
                1e3 * writtenSpacing(f.chosen.scene));
  else if (!f.chosen.scene.discretization.refine.empty())
    std::printf(
        "  nodes                  %.3g mm apart within %.3g mm of where the tool works, %.3g mm elsewhere (--uniform: "
        "the same everywhere)\n",
        1e3 * f.chosen.scene.discretization.refine.front().spacing,
        1e3 * f.chosen.scene.discretization.refine.front().radius, 1e3 * f.chosen.scene.discretization.spacing);
  for (const auto& c : f.candidates)
    std::printf(
        "  %s %s, spacing x %.3g: %d nodes, up to %.2f %% of the force, root mean square %.2f %% of the largest\n",
        c.family == f.chosen.family && c.spacing_factor == f.chosen.spacing_factor ? "chosen               "
                                                                                   : "also                 ",
        c.family.c_str(), c.spacing_factor, c.nodes, 100 * c.expected.loaded, 100 * c.expected.force);
  std::printf("  scene                  %s\n", f.order.out.c_str());
}

std::string jsonOf(const Fitted& f) {
  const nlohmann::ordered_json json = {
      {"scene", f.order.given.name},
      {"file", f.order.out},
      {"rate_hz", f.order.scene.dynamics.rate_hz},
      {"threads", f.order.scene.dynamics.threads},
      {"family", f.chosen.family},
      {"mass_scaling", f.chosen.scene.dynamics.mass_scaling},
      {"follows", f.chosen.scene.discretization.follow},
      {"spacing_m", writtenSpacing(f.chosen.scene)},
      {"spacing_where_the_tool_works_m", writtenSpacing(f.chosen.scene) * f.chosen.inside},
      {"nodes", f.chosen.nodes},
      {"points", f.chosen.points},
      {"substeps", f.chosen.substeps},
      {"rate_held", f.held.held(f.order.scene.dynamics.rate_hz)},
      {"expected_force_error", f.chosen.expected.force},
      {"expected_largest_force_error", f.chosen.expected.loaded},
      {"distance_from_reference", f.chosen.error.force},
      {"reference_nodes", f.reference_nodes},
      {"tick_p999_us", f.held.step_us.p999},
      {"headroom", f.headroom()},
      {"overruns", f.held.overruns},
      {"ticks", f.held.ticks},
      {"realtime_factor", f.held.realtime_factor},
      {"build", buildInfo()}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

int fit(const FitOptions& options) {
  const FitOrder order = orderOf(options);
  const Scene& scene = order.scene;

  ProgressLine progress("fit");
  progress.show(0, "set-up");
  const Model present = loadModel(scene, {}, ModelCache(), warn);
  FitWay w{present, scriptedTrajectory(present, order.script), surfaceProbes(present, probe_count)};
  const auto families =
      fitFamilies(scene, options.uniform ? std::vector<ContactRegion>() : contactRegions(present, w.way));
  const std::vector<double> asked = {scene.dynamics.rate_hz, static_cast<double>(scene.dynamics.threads)};
  FitRecord record(order.stem + ".fit.json", runIdentity(present, w.way, asked));
  if (options.resume) record.resume();

  FitTask task{scene, w.way, w.probes, scene.dynamics.threads, record, {}};
  std::vector<FitCandidate> candidates = finestOfEach(task, families, progress);
  stopIfInterrupted();
  if (candidates.empty()) {
    std::cerr << "mtled: no setting of this scene holds " << scene.dynamics.rate_hz << " Hz with "
              << scene.dynamics.threads << " threads on this machine\n";
    return 1;
  }
  const Fineness fineness = finerThan(candidates, present);
  const ConvergedRun converged = referenceRun(options, order, w, fineness, progress);
  for (auto& c : candidates) {
    c.error = errorOf(c.run, converged.run);
    c.expected = expectedError(c.error, converged, fineness.coarser);
  }
  FitCandidate chosen;
  const HeldRate held = heldInTheLoop(task, families, converged, fineness, candidates, chosen, progress);
  stopIfInterrupted();
  progress.show(1, "done");
  const bool is_held = held.held(scene.dynamics.rate_hz);
  std::string text = textFor(order, chosen.scene);
  if (!says(sceneIn(text, order.out), chosen.scene))
    throw InputError({order.out}, "this scene file's layout keeps `mtled fit` from changing it",
                     "write spacing, support_factor, points_per_cell and cells_per_point into a [discretization] "
                     "table, rate, time_step and threads into [dynamics]");
  if (!is_held)
    text.insert(0, format("# Not confirmed: %.6g Hz were not held in the real-time loop.\n", scene.dynamics.rate_hz));
  writeWholeFile(order.out, text);
  const Fitted fitted{order, chosen, candidates, held, converged.about.nodes};
  printFitted(fitted);
  if (!options.json.empty()) writeWholeFile(options.json, jsonOf(fitted));
  if (is_held) return 0;
  std::cerr << "mtled: " << order.out << " is not confirmed: " << scene.dynamics.rate_hz
            << " Hz were not held in the real-time loop, " << held.overruns << " of " << held.ticks + held.overruns
            << " periods missed, p99.9 " << held.step_us.p999 << " us. End other programs and go on with --resume\n";
  return 1;
}

}  // namespace

int fitCommand(const FitOptions& options) {
  try {
    return fit(options);
  } catch (const std::runtime_error&) {
    if (!interrupted()) throw;
    std::cerr << "mtled: interrupted; --resume goes on with what was not tried yet\n";
    return 1;
  }
}

}  // namespace palpate::tools

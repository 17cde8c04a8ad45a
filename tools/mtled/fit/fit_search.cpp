#include "mtled/fit/fit_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/input_error.h"
#include "base/interrupt.h"
#include "base/number_text.h"
#include "io/load_model.h"
#include "mtled/run/following_run.h"

namespace palpate::tools {
namespace {

constexpr int max_tries = 5;
constexpr int max_nodes = 40000;
constexpr double coarsest = 4;  // times the given spacing
constexpr double some_pairs =
    1.5;  // cells a point: a third fewer points, and more nodes for that, are mostly more exact
constexpr double some_mass = 0.05;  // of the body's: motion becomes slower by half of that

}  // namespace

std::vector<FitFamily> fitFamilies(const Scene& scene, const std::vector<ContactRegion>& places) {
  std::vector<FitFamily> families;
  const auto add = [&](double support, double inside, double mass, double cells_per_point = some_pairs) {
    std::string name = format("support_factor %g", support);
    if (cells_per_point > 1) name += format(", %g cells a point", cells_per_point);
    if (inside < 1) name += format(", spacing x %g where the tool works", inside);
    if (mass > 0) name += format(", mass_scaling %g", mass);
    families.push_back({name,
                        [=](Scene& s) {
                          s.discretization.support_factor = support;
                          s.discretization.quadrature = {1, cells_per_point, 0, 8, 4};
                          s.discretization.formulation = Formulation{};
                          s.dynamics.time_step = 0;
                          s.dynamics.mass_scaling = mass;
                          if (inside < 1) refineWhere(s, places, 1, inside);
                        },
                        inside});
  };
  const double given = scene.dynamics.mass_scaling, more = std::max(given, some_mass);
  if (scene.discretization.follow) {  // it knows itself where nodes are worth it
    const auto follows = [&](const std::string& name, double mass) {
      families.push_back({name,
                          [mass](Scene& s) {
                            s.dynamics.time_step = 0;
                            s.dynamics.mass_scaling = mass;
                          },
                          1});
    };
    follows("a cloud that follows", given);
    if (more > given) follows(format("a cloud that follows, mass_scaling %g", more), more);
    return families;
  }
  add(scene.discretization.support_factor, 1, given);
  add(scene.discretization.support_factor, 1, given, 1);
  if (scene.discretization.support_factor < 2.1) add(2.2, 1, given);
  const bool refined = !places.empty();
  if (refined)
    for (const double inside : {0.6, 0.4}) add(scene.discretization.support_factor, inside, given);
  // Small cells limit the step: a little mass on them may spare steps.
  if (more > given) add(scene.discretization.support_factor, refined ? 0.4 : 1, more);
  return families;
}

FitCandidate tried(const FitTask& task, const FitFamily& family, double factor) {
  FitCandidate c;
  c.inside = family.inside;
  c.scene = task.scene;
  family.turn(c.scene);
  scaleSpacing(c.scene, factor);
  FitTry& one = c;
  if (const FitTry* known = task.record.find(family.name, factor)) {
    one = *known;
    return c;
  }
  one.family = family.name;
  one.spacing_factor = factor;
  try {
    if (c.scene.discretization.follow) {
      const auto following = loadFollowing(c.scene);
      PlaceShelf shelf(following->places());
      FollowingRun run = followTrajectory(following->places(), shelf, task.way, task.probes, task.threads);
      one.nodes = run.most_nodes;
      one.points = following->start()->model.pointCount();
      one.substeps = run.substeps;
      one.run = std::move(run.run);
    } else {
      const Model model = loadModel(c.scene);
      one.nodes = model.nodeCount();
      one.points = model.pointCount();
      one.substeps = model.substeps_per_tick;
      one.run = runTrajectory(model, task.way, task.probes, task.threads);
    }
    one.cost = costOf(one.run, c.scene.dynamics.rate_hz);
  } catch (const InputError&) {  // a setting that this scene can't have
  }
  if (!one.run.interrupted) task.record.add(one);
  return c;
}

FitCandidate finestWithin(const FitTask& task, const FitFamily& family, double share, double start) {
  const double limit = share * 1e6 / task.scene.dynamics.rate_hz;  // us
  FitCandidate best;
  best.spacing_factor = 0;
  double factor = start, too_fine = 0;
  for (int k = 0; k < max_tries && !interrupted(); ++k) {
    task.watch(static_cast<double>(k) / max_tries, family.name + format(", spacing x %.3g", factor));
    FitCandidate c = tried(task, family, factor);
    if (c.nodes == 0 || c.run.interrupted) break;
    const double ratio = c.cost.tick_p50 / limit;
    const bool fits = ratio <= 1 && c.run.sound();
    if (fits && (best.spacing_factor == 0 || factor < best.spacing_factor)) best = c;
    if (!fits) too_fine = std::max(too_fine, factor);
    if (fits && ratio > 0.85) break;
    // Points and steps a tick: between the third and the fourth power of the spacing.
    double next = factor * std::pow(ratio / 0.93, 1 / 3.5);
    if (!c.run.sound()) next = 1.3 * factor;  // too fine a cloud under the tool; nothing known of a finer one's time
    next = std::max(next, factor * std::cbrt(static_cast<double>(c.nodes) / max_nodes));
    // Whole steps a tick make the time jump: never beyond what is known not to fit.
    if (too_fine > 0 && next <= too_fine)
      next = best.spacing_factor > 0 ? std::sqrt(too_fine * best.spacing_factor) : 1.1 * too_fine;
    if (next > coarsest || std::abs(next / factor - 1) < 0.01) break;
    factor = next;
  }
  return best;
}

Fineness fitFineness(double outside, double inside) {
  return {0.85 * outside, std::min(0.5 * outside, 0.75 * inside), 1.35};
}

RunError expectedError(const RunError& error, const ConvergedRun& converged, double coarser) {
  const auto expected = [&](double distance, double of_reference) {
    const double lacking = of_reference / (coarser * coarser - 1);
    return std::max(std::hypot(distance, lacking), converged.about.layer_error);
  };
  const RunError& reference = converged.about.convergence;
  return {.force = expected(error.force, reference.force), .loaded = expected(error.loaded, reference.loaded)};
}

}  // namespace palpate::tools

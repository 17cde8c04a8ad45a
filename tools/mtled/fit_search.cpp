#include "mtled/fit_search.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/interrupt.h"
#include "io/load_model.h"

namespace palpate {
namespace {

constexpr int most_tries = 5;
constexpr int most_nodes = 40000;
constexpr double coarsest = 4;  // times the given spacing

FitCandidate measured(const FitTask& task, const FitFamily& family, double factor) {
  FitCandidate c;
  c.family = family.name;
  c.scene = task.scene;
  family.turn(c.scene);
  scaleSpacing(c.scene, factor);
  c.spacing_factor = factor;
  const Model model = loadModel(c.scene);
  c.nodes = model.nodeCount();
  c.points = model.pointCount();
  c.substeps = model.substeps_per_tick;
  c.run = runWay(model, task.way, task.probes, task.threads);
  c.cost = costOf(c.run, c.scene.rate_hz);
  return c;
}

}  // namespace

std::vector<FitFamily> fitFamilies(const Scene& scene) {
  std::vector<FitFamily> families;
  std::vector<double> supports{scene.support_factor};
  if (scene.support_factor < 2.1) supports.push_back(2.2);
  for (const double support : supports) {
    char name[64];
    std::snprintf(name, sizeof name, "support_factor %g", support);
    families.push_back({name, [support](Scene& s) {
                          s.support_factor = support;
                          s.quadrature = {1, 0, 8, 4};
                          s.consistent_gradients = s.node_patch_volume = true;
                          s.time_step = 0;
                        }});
  }
  return families;
}

FitCandidate finestWithin(const FitTask& task, const FitFamily& family, double share) {
  const double limit = share * 1e6 / task.scene.rate_hz;  // us
  FitCandidate best;
  best.spacing_factor = 0;
  double factor = 1, too_fine = 0;
  for (int k = 0; k < most_tries && !interrupted(); ++k) {
    char what[96];
    std::snprintf(what, sizeof what, "%s, spacing x %.3g", family.name.c_str(), factor);
    task.watch(static_cast<double>(k) / most_tries, what);
    FitCandidate c = measured(task, family, factor);
    const double ratio = c.cost.tick_p50 / limit;
    const bool fits = ratio <= 1 && c.run.sound();
    if (fits && (best.spacing_factor == 0 || factor < best.spacing_factor)) best = c;
    if (!fits) too_fine = std::max(too_fine, factor);
    if (fits && ratio > 0.85) break;
    // Points and steps a tick: between the third and the fourth power of the spacing.
    double next = factor * std::pow(ratio / 0.93, 1 / 3.5);
    if (!c.run.sound()) next = 1.3 * factor;  // too fine a cloud under the tool; nothing known of a finer one's time
    next = std::max(next, factor * std::cbrt(static_cast<double>(c.nodes) / most_nodes));
    // Whole steps a tick make the time jump: never beyond what is known not to fit.
    if (too_fine > 0 && next <= too_fine) next = best.spacing_factor > 0 ? std::sqrt(too_fine * best.spacing_factor) : 1.1 * too_fine;
    if (next > coarsest || std::abs(next / factor - 1) < 0.01) break;
    factor = next;
  }
  return best;
}

Fineness fitFineness(double factor) { return {0.85 * factor, 0.5 * factor, 1.35}; }

double expectedError(const RunError& error, const ConvergedRun& converged, double coarser) {
  const double lacking = converged.about.convergence.force / (coarser * coarser - 1);
  return std::hypot(error.force, lacking);
}

}  // namespace palpate

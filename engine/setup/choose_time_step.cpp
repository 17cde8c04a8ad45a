#include "setup/choose_time_step.h"

#include <algorithm>
#include <cmath>

#include "scene/scene_messages.h"
#include "scene/scene_regions.h"

namespace palpate {
namespace {

/// How far the tool may go in a step for the contact to follow without tunnelling (contact/tool_rows.h), and
/// without pushing the tissue over a good part of the half spacing that counts as lost, m.
double reachOf(const Scene& scene) {
  double spacing = scene.discretization.spacing;
  for (const RefineSpec& refine : scene.discretization.refine) spacing = std::min(spacing, refine.spacing);
  return std::min({1e-3, smallestToolRadius(scene) / 2, spacing / 4});
}

/// Steps of a tick, a whole number, for the tool's reach and a body with this critical step.
double stepsPerTick(const Scene& scene, double dt_critical) {
  const double longest = std::min(scene.dynamics.step_safety * dt_critical, reachOf(scene) / largestToolSpeed(scene));
  return std::max(1.0, std::ceil(1 / scene.dynamics.rate_hz / longest * (1 - 1e-9)));
}

/// The material with the fastest waves: what makes the critical step short.
const MaterialSpec& stiffestMaterial(const Scene& scene) {
  const auto speed = [](const MaterialSpec& spec) { return spec.material.waveModulus() / spec.material.density; };
  return *std::max_element(scene.materials.begin(), scene.materials.end(),
                           [&](const MaterialSpec& a, const MaterialSpec& b) { return speed(a) < speed(b); });
}

[[noreturn]] void refuseSteps(const SourceLocation& place, double steps, const std::string& why,
                              const std::string& advice) {
  throw InputError(place,
                   number(steps) + " steps would make a tick, more than the " + number(max_steps_per_tick) +
                       " that one may have: " + why,
                   advice);
}

/// Refuses more steps to a tick than are taken, at the key that asks for them.
void checkChosenSteps(const Scene& scene, double steps, const CriticalTimeStep& limit, const std::vector<Vec3>& X) {
  if (steps <= max_steps_per_tick) return;
  const double needed = 1 / scene.dynamics.rate_hz / max_steps_per_tick;  // s, the shortest step that is taken
  const std::string critical = "the critical step is " + number(limit.dt) + " s (the stiffest row is the node at " +
                               coordinates(X[limit.worst_node]) + ")";
  if (limit.dt > needed)
    refuseSteps(placeOf(scene, "dynamics.step_safety"), steps, critical,
                "raise dynamics.step_safety to more than " + number(needed / limit.dt));
  const MaterialSpec& stiffest = stiffestMaterial(scene);
  const SourceLocation& material = stiffest.place;
  // What waves need from node to node, were these as far apart as the scene says.
  double spacing = scene.discretization.spacing;
  for (const RefineSpec& refine : scene.discretization.refine) spacing = std::min(spacing, refine.spacing);
  const double of_stiffness = spacing / std::sqrt(stiffest.material.waveModulus() / stiffest.material.density);
  constexpr double crowded = 0.01;
  if (scene.materials.size() > 1 && limit.dt < crowded * of_stiffness) {
    const auto index = static_cast<std::size_t>(&stiffest - scene.materials.data());
    refuseSteps(material.file.empty() ? scene.place : material, steps, critical,
                "not for its stiffness: there the border of material " + std::to_string(index + 1) +
                    (stiffest.name.empty() ? "" : " (\"" + stiffest.name + "\")") +
                    " and the skin, or another border, are closer to one another than nodes " + number(spacing) +
                    " m apart can be put between. Lower discretization.spacing to about the layer's thickness there "
                    "([[discretization.refine]]), or thicken the layer, or leave it out");
  }
  refuseSteps(material.file.empty() ? scene.place : material, steps, critical,
              "is this material's stiffness in Pa? Soften it, or coarsen discretization.spacing");
}

}  // namespace

double longestCriticalStep(const Scene& scene, double dt_critical, const std::function<bool(double)>& grants) {
  if (scene.dynamics.time_step > 0) {
    const double needed = scene.dynamics.time_step / scene.dynamics.step_safety;
    return dt_critical < scene.dynamics.time_step && grants(needed) ? needed : 0;
  }
  double longest = 0;
  const auto holds = [&](double steps) {
    const double needed = 1 / scene.dynamics.rate_hz / steps / scene.dynamics.step_safety;
    // The tool may ask for short steps; and a safety that asks for steps of a thousand ticks has a number wrong.
    if (stepsPerTick(scene, needed) > steps || needed > 1e3 / scene.dynamics.rate_hz || !grants(needed)) return false;
    longest = needed;
    return true;
  };
  const double steps = stepsPerTick(scene, dt_critical);
  constexpr double many = 16;
  if (steps <= many) {
    for (double fewer = steps - 1; fewer >= 1 && holds(fewer);) --fewer;
    return longest;
  }
  // A sliver asks for millions of steps, and for next to no mass to be spared them: up from one step, then between.
  double refused = 0, granted = 1;
  for (; !holds(granted); granted *= 2) {
    refused = granted;
    if (2 * granted >= std::min(steps, 1.0 * max_steps_per_tick)) return 0;
  }
  while (granted - refused > 1) {
    const double middle = std::floor(0.5 * (granted + refused));
    (holds(middle) ? granted : refused) = middle;
  }
  return longest;
}

void checkStepsAsked(const Scene& scene) {
  const double tick = 1 / scene.dynamics.rate_hz, reach = reachOf(scene), shortest = tick / max_steps_per_tick;
  if (scene.dynamics.time_step > 0) {
    const double steps = std::round(tick / scene.dynamics.time_step);
    if (steps > max_steps_per_tick)
      refuseSteps(placeOf(scene, "dynamics.time_step"), steps,
                  "time_step is " + number(scene.dynamics.time_step) + " s",
                  "raise it to at least " + number(shortest) + " s, or leave it out");
    return;
  }
  const double steps = std::ceil(tick / (reach / largestToolSpeed(scene)) * (1 - 1e-9));
  if (steps > max_steps_per_tick)
    refuseSteps(placeOf(scene, scene.places.contains("tool.max_speed") ? "tool.max_speed" : "tool.radius"), steps,
                "the contact follows the tool no further than " + number(reach) + " m in a step",
                "lower tool.max_speed to " + number(reach / shortest) + " m/s, or raise tool.radius and the spacing");
}

void chooseTimeStep(const Scene& scene, const CriticalTimeStep& limit, const std::vector<Vec3>& X, Model& model) {
  checkStepsAsked(scene);
  model.dt_critical = limit.dt;
  model.dt_proven = limit.dt_proven;
  const double tick = 1 / scene.dynamics.rate_hz;
  const double reach = reachOf(scene);
  if (scene.dynamics.time_step > 0) {
    const SourceLocation place = placeOf(scene, "dynamics.time_step");
    const double substeps = std::round(tick / scene.dynamics.time_step);
    if (substeps < 1 || std::abs(substeps * scene.dynamics.time_step - tick) > 1e-6 * tick)
      throw InputError(place,
                       "a tick of " + number(tick) + " s is not a whole number of steps of " +
                           number(scene.dynamics.time_step) + " s",
                       "use " + number(tick / std::max(1.0, std::ceil(tick / scene.dynamics.time_step))) +
                           " s, or leave time_step out");
    model.substeps_per_tick = static_cast<int>(substeps);
    if (scene.dynamics.time_step > limit.dt)
      throw InputError(place,
                       "time_step " + number(scene.dynamics.time_step) + " s exceeds the critical " + number(limit.dt) +
                           " s (the stiffest row is the node at " + coordinates(X[limit.worst_node]) + ")",
                       scene.dynamics.mass_scaling > 0 ? "lower time_step, or raise mass_scaling"
                                                       : "lower time_step, or coarsen discretization.spacing");
    if (largestToolSpeed(scene) * scene.dynamics.time_step > reach * (1 + 1e-9))
      throw InputError(place,
                       "at tool.max_speed the tool travels " +
                           number(largestToolSpeed(scene) * scene.dynamics.time_step) + " m in a step, more than the " +
                           number(reach) + " m that the contact follows",
                       "lower time_step to " + number(reach / largestToolSpeed(scene)) + " s, or tool.max_speed");
  } else {
    const double steps = stepsPerTick(scene, limit.dt);
    checkChosenSteps(scene, steps, limit, X);
    model.substeps_per_tick = static_cast<int>(steps);
  }
  model.dt = tick / model.substeps_per_tick;
}

}  // namespace palpate

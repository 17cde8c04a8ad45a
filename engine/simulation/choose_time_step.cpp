#include "simulation/choose_time_step.h"

#include <algorithm>
#include <cmath>

#include "simulation/scene_messages.h"

namespace palpate {
namespace {

/// How far the tool may go in a step for the contact to follow without tunnelling (contact/contact_solver.h), m.
double reachOf(const Scene& scene) { return std::min(1e-3, scene.tool.radius / 2); }

/// Steps of a tick, for the tool's reach and a body with this critical step.
int stepsPerTick(const Scene& scene, double dt_critical) {
  const double longest = std::min(scene.step_safety * dt_critical, reachOf(scene) / scene.tool_max_speed);
  return std::max(1, static_cast<int>(std::ceil(1 / scene.rate_hz / longest * (1 - 1e-9))));
}

}  // namespace

double nextCriticalStep(const Scene& scene, double dt_critical) {
  if (scene.time_step > 0) return dt_critical < scene.time_step ? scene.time_step / scene.step_safety : 0;
  const int fewer = stepsPerTick(scene, dt_critical) - 1;
  if (fewer < 1) return 0;
  const double needed = 1 / scene.rate_hz / fewer / scene.step_safety;
  return stepsPerTick(scene, needed) <= fewer ? needed : 0;  // else it is the tool that asks for short steps
}

void chooseTimeStep(const Scene& scene, const CriticalTimeStep& limit, const std::vector<Vec3>& X, Model& model) {
  model.dt_critical = limit.dt;
  model.dt_proven = limit.dt_proven;
  const double tick = 1 / scene.rate_hz;
  const double reach = reachOf(scene);
  if (scene.time_step > 0) {
    const SourceLocation place = placeOf(scene, "dynamics.time_step");
    const double substeps = std::round(tick / scene.time_step);
    if (substeps < 1 || std::abs(substeps * scene.time_step - tick) > 1e-6 * tick)
      throw InputError(
          place, "a tick of " + number(tick) + " s is not a whole number of steps of " + number(scene.time_step) + " s",
          "use " + number(tick / std::max(1.0, std::ceil(tick / scene.time_step))) + " s, or leave time_step out");
    model.substeps_per_tick = static_cast<int>(substeps);
    if (scene.time_step > limit.dt)
      throw InputError(place,
                       "time_step " + number(scene.time_step) + " s exceeds the critical " + number(limit.dt) +
                           " s (the stiffest row is the node at " + coordinates(X[limit.worst_node]) + ")",
                       scene.mass_scaling > 0 ? "lower time_step, or raise mass_scaling"
                                              : "lower time_step, or coarsen discretization.spacing");
    if (scene.tool_max_speed * scene.time_step > reach * (1 + 1e-9))
      throw InputError(place,
                       "at tool.max_speed the tool travels " + number(scene.tool_max_speed * scene.time_step) +
                           " m in a step, more than the " + number(reach) + " m that the contact follows",
                       "lower time_step to " + number(reach / scene.tool_max_speed) + " s, or tool.max_speed");
  } else {
    model.substeps_per_tick = stepsPerTick(scene, limit.dt);
  }
  model.dt = tick / model.substeps_per_tick;
}

}  // namespace palpate

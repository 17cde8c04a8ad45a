#include "simulation/choose_time_step.h"

#include <algorithm>
#include <cmath>

#include "simulation/scene_messages.h"

namespace palpate {

void chooseTimeStep(const Scene& scene, const CriticalTimeStep& limit, const std::vector<Vec3>& X, Model& model) {
  model.dt_critical = limit.dt;
  model.dt_proven = limit.dt_proven;
  const double tick = 1 / scene.rate_hz;
  // How far the tool may go in a step for the contact to follow without tunnelling (contact/contact_solver.h).
  const double reach = std::min(1e-3, scene.tool.radius / 2);
  if (scene.time_step > 0) {
    const Place place = placeOf(scene, "dynamics.time_step");
    const double substeps = std::round(tick / scene.time_step);
    if (substeps < 1 || std::abs(substeps * scene.time_step - tick) > 1e-6 * tick)
      throw InputError(place, "a tick of " + number(tick) + " s is not a whole number of steps of " + number(scene.time_step) + " s",
                       "use " + number(tick / std::max(1.0, std::ceil(tick / scene.time_step))) + " s, or leave time_step out");
    model.substeps_per_tick = static_cast<int>(substeps);
    if (scene.time_step > limit.dt)
      throw InputError(place, "time_step " + number(scene.time_step) + " s exceeds the critical " + number(limit.dt) +
                                  " s (the stiffest row is the node at " + coordinates(X[limit.worst_node]) + ")",
                       "lower time_step, or coarsen discretization.spacing");
    if (scene.tool_max_speed * scene.time_step > reach * (1 + 1e-9))
      throw InputError(place, "at tool.max_speed the tool travels " + number(scene.tool_max_speed * scene.time_step) +
                                  " m in a step, more than the " + number(reach) + " m that the contact follows",
                       "lower time_step to " + number(reach / scene.tool_max_speed) + " s, or tool.max_speed");
  } else {
    const double longest = std::min(scene.step_safety * limit.dt, reach / scene.tool_max_speed);
    model.substeps_per_tick = std::max(1, static_cast<int>(std::ceil(tick / longest * (1 - 1e-9))));
  }
  model.dt = tick / model.substeps_per_tick;
}

}  // namespace palpate

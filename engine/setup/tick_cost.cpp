#include "setup/tick_cost.h"

#include <cmath>

#include "scene/scene_messages.h"
#include "setup/place.h"

namespace palpate {

double expectedLoad(const Body& body) {
  return seconds_per_point_and_step * body.pointCount() * body.substeps_per_tick / body.scene.dynamics.threads *
         body.scene.dynamics.rate_hz;
}

std::string rateWarning(const Body& body) {
  const double load = expectedLoad(body);
  if (!(load > 1)) return {};
  const Scene& scene = body.scene;
  // A place has the step of the first one.
  const bool follows =
      !scene.places.empty() && (scene.discretization.at_tools > 0 || !scene.places.contains("discretization.spacing"));
  const bool own_step = scene.dynamics.time_step > 0 && (!follows || scene.places.contains("dynamics.time_step"));
  const std::string place = placeOf(scene, own_step ? "dynamics.time_step" : "discretization.spacing").text();
  const double period = 1e3 / scene.dynamics.rate_hz;  // ms
  // A coarser body has fewer points, by the third power of the spacing, and a longer stable step. A lower rate has as
  // many steps in a second, unless a tick has only one.
  const double present = follows ? fineSpacing(scene) : scene.discretization.spacing;
  const std::string coarser = "a spacing of about " + number(present * std::pow(load, 0.25)) + " m" +
                              (follows ? " near the tool (follow = true, spacing)" : "");
  const std::string threads = scene.dynamics.threads == 1 ? "give dynamics.threads more, " : "";
  const std::string advice = own_step                          ? "leave time_step out, or choose "
                             : body.substeps_per_tick == 1     ? "lower dynamics.rate, or choose "
                             : scene.dynamics.mass_scaling > 0 ? "allow more dynamics.mass_scaling, or choose "
                                                               : "allow dynamics.mass_scaling, or choose ";
  return (place.empty() ? "" : place + ": ") +
         format(
             "the scene will hardly hold its rate: a tick takes %d step%s of %d points, about %s ms of computing in "
             "%s ms (%.0f ns a point and step, %d thread%s), so time will go about %s times slower; ",
             body.substeps_per_tick, body.substeps_per_tick == 1 ? "" : "s", body.pointCount(),
             number(load * period).c_str(), number(period).c_str(), 1e9 * seconds_per_point_and_step,
             scene.dynamics.threads, scene.dynamics.threads == 1 ? "" : "s",
             format(load < 10 ? "%.1f" : "%.0f", load).c_str()) +
         threads + advice + coarser;
}

}  // namespace palpate

// Tools that give way to more than their max_force, within the step.

#include <algorithm>
#include <catch2/catch.hpp>

#include "model/model_hash.h"
#include "step/step.h"
#include "step/tool_bodies.h"
#include "step/workspace.h"
#include "support/small_scene.h"
#include "support/strip_scene.h"

using namespace palpate;
using namespace palpate::test;

namespace {

/// A blow at 0.5 m/s, 12 mm deep, a stay there, and out again.
Pose blowAt(const Model& model, int tick) {
  const double deepest = model.tools.first().first_contact_travel + 0.012, step = 0.5 / model.scene.dynamics.rate_hz;
  const int down = static_cast<int>(deepest / step), out = down + 50;
  return toolAt(model, tick <= out ? std::min(deepest, tick * step) : std::max(0.0, deepest - (tick - out) * step));
}

struct Outcome {
  std::uint64_t hash = 0;
  double peak = 0;     // N
  int above = 0;       // ticks above the limit
  int near_limit = 0;  // ticks with 0.8 to 1 of it
  double deepest = 0;  // m, of the tool's travel
  Vec3 end;
};

Outcome strike(const Model& model, int ticks = 140) {
  State state = initialState(model);
  Workspace workspace(model, 1);
  Outcome outcome;
  Command command;
  for (int k = 1; k <= ticks; ++k) {
    command.tools[0].pose = blowAt(model, k);
    const double force = tick(model, state, command, workspace).tool_force.norm(),
                 limit = model.tools.first().max_force;
    outcome.peak = std::max(outcome.peak, force);
    outcome.above += limit > 0 && force > 1.0001 * limit;
    outcome.near_limit += limit > 0 && force > 0.8 * limit && force <= 1.0001 * limit;
    outcome.deepest =
        std::max(outcome.deepest, model.tools.first().start.pose.position.z() - state.tool[0].pose.position.z());
  }
  outcome.hash = stateHash(model, state);
  outcome.end = state.tool[0].pose.position;
  return outcome;
}

}  // namespace

TEST_CASE("No tick of a blow has more than the tool's max_force", "[yielding]") {
  Model model = blockModel();
  model.tools.first().max_force = 0;
  const Outcome stiff = strike(model);
  model.tools.first().max_force = 0.4 * stiff.peak;
  const Outcome held = strike(model);
  INFO("peak " << stiff.peak << " N, held to " << held.peak << " of " << model.tools.first().max_force << " N in "
               << held.near_limit << " ticks");
  CHECK(held.above == 0);
  CHECK(held.near_limit > 3);  // a hand at its limit, not one that lets go
  CHECK(held.deepest < stiff.deepest);
  CHECK(held.deepest > 0.5 * stiff.deepest);
  CHECK(held.end == blowAt(model, 140).position);  // out again it goes as it is led
}

TEST_CASE("A limit that is not nearly reached changes no bit", "[yielding]") {
  Model model = blockModel();
  model.tools.first().max_force = 0;
  const Outcome free = strike(model);
  model.tools.first().max_force = 1.06 * free.peak;
  const Outcome limited = strike(model);
  CHECK(limited.hash == free.hash);
  CHECK(limited.peak == free.peak);
}

TEST_CASE("Jaws open where the pinch would be above their grip force", "[yielding][whole]") {
  const Model model = stripModel();
  const auto pinch = [&](double limit) {
    Model limited = model;
    limited.tools.tool[0].grip_force = limit;
    State state = initialState(limited);
    Workspace workspace(limited, 1);
    double peak = 0;
    for (int k = 1; k <= 30; ++k) {
      Command command = restCommand(limited);
      command.tools[0].opening = std::max(0.004, 0.012 - 3e-4 * k);
      peak = std::max(peak, tick(limited, state, command, workspace).loads[0].pinch);
    }
    return std::pair{peak, state.tool[0].opening};
  };
  const auto [free_peak, closed] = pinch(0);
  const auto [peak, opening] = pinch(0.5 * free_peak);
  CHECK(peak <= 1.0001 * 0.5 * free_peak);
  CHECK(peak > 0.8 * 0.5 * free_peak);
  CHECK(closed == Approx(0.004));
  CHECK(opening > closed);
}

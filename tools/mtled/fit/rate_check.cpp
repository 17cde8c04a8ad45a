#include "mtled/fit/rate_check.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

#include "base/interrupt.h"
#include "io/load_model.h"
#include "realtime/loop/cloud_follower.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate::tools {

namespace {

/// The tools' ways, and back, again and again.
std::vector<TimedRequest> thereAndBack(const ToolTrajectory& way, const ToolSet& tools, std::int64_t ticks) {
  std::vector<TimedRequest> track;
  const auto count = static_cast<std::int64_t>(way.size());
  for (std::int64_t k = 0; k < ticks; ++k) {
    const std::int64_t along = k % (2 * count);
    const ToolPostures& at = way[static_cast<std::size_t>(std::min(along, 2 * count - 1 - along))];
    track.push_back({k, Request::moveTool(at[0].pose)});
    for (int t = 0; t < tools.toolCount(); ++t) {
      const auto tool = static_cast<std::size_t>(t);
      if (t > 0) track.push_back({k, Request::moveHand(t, at[tool].pose)});
      if (tools.tool[tool].jaws) track.push_back({k, Request::setOpening(t, at[tool].opening)});
    }
  }
  return track;
}

}  // namespace

bool HeldRate::held(double rate_hz) const {
  return !frozen && ticks > 0 && static_cast<double>(overruns) < 1e-3 * static_cast<double>(ticks + overruns) &&
         step_us.p999 < 1e6 / rate_hz;
}

HeldRate checkRate(Scene scene, const ToolTrajectory& way, int threads, double seconds) {
  scene.dynamics.catch_up = 0;  // a rate that is held needs none
  std::optional<Model> stays;
  std::optional<TissuePhysics> own;
  std::optional<FollowingTissue> follows;
  if (scene.discretization.follow) {
    follows.emplace(loadFollowing(scene), threads, true);
  } else {
    own.emplace(stays.emplace(loadModel(scene)), threads);
  }
  const Model& model = follows ? follows->model() : *stays;
  TissuePhysics& physics = follows ? follows->physics : *own;
  SimulationLoopOptions options;
  if (follows) options.follower = &follows->follower;
  const auto ticks = static_cast<std::int64_t>(std::ceil(seconds * scene.dynamics.rate_hz));
  options.tick_limit = ticks;
  options.track = thereAndBack(way, model.tools, ticks);
  SimulationLoop loop(model, physics, &physics.team(), options);
  loop.start();
  ForceSample sample;
  while (!loop.finished()) {
    if (interrupted()) loop.quit();
    while (loop.forces().pop(sample)) {
    }  // nobody else takes them
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  loop.join();
  const auto& statistics = loop.statistics();
  return {statistics.step.percentiles(), statistics.ticks.load(), statistics.overrun_count.load(),
          loop.summary().totals.realtime_factor, loop.summary().frozen};
}

}  // namespace palpate::tools

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
#include "realtime/recording/recording.h"

namespace palpate::tools {

bool HeldRate::held(double rate_hz) const {
  return !frozen && ticks > 0 && static_cast<double>(overruns) < 1e-3 * static_cast<double>(ticks + overruns) &&
         step_us.p999 < 1e6 / rate_hz;
}

HeldRate checkRate(Scene scene, const ToolTrajectory& way, int threads, double seconds) {
  ToolTrajectory there_and_back = way;
  there_and_back.insert(there_and_back.end(), way.rbegin(), way.rend());
  const auto ticks = static_cast<std::size_t>(std::ceil(seconds * scene.dynamics.rate_hz));
  std::vector<Pose> poses;
  while (poses.size() < ticks) poses.insert(poses.end(), there_and_back.begin(), there_and_back.end());

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
  options.track = trackFromPoses(poses);
  options.tick_limit = static_cast<std::int64_t>(poses.size());
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

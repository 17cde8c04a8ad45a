#include "mtled/run/following_run.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>

#include "base/interrupt.h"
#include "step/step.h"
#include "step/tool_contact.h"
#include "step/workspace.h"

namespace palpate::tools {
namespace {

constexpr double watched_seconds = 0.12;  // after a swap
constexpr double least_load = 0.02;       // of the largest force so far: below it a swap has nothing to disturb

double processorSeconds(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// @return the first tool's force, N
Vec3 timedTick(SteppedTissue& tissue, const ToolPostures& tools, ScriptedRun& run) {
  const double start = processorSeconds(CLOCK_THREAD_CPUTIME_ID);
  const StepReport report = tissue.tickTo(tools);
  run.tick_us.push_back(1e6 * (processorSeconds(CLOCK_THREAD_CPUTIME_ID) - start));
  run.add(tissue.model, report.loads, report.flags, static_cast<double>(report.min_J));
  return report.tool_force;
}

}  // namespace

const Place& PlaceShelf::at(const PlaceIndex& index) {
  auto& place = shelf_[index];
  if (!place) {
    const double start = processorSeconds(CLOCK_PROCESS_CPUTIME_ID);
    place = std::make_unique<Place>(makePlace(places_, index));
    seconds_ += processorSeconds(CLOCK_PROCESS_CPUTIME_ID) - start;
  }
  return *place;
}

FollowingRun followTrajectory(const Places& places, PlaceShelf& shelf, const ToolTrajectory& way,
                              const std::vector<Vec3>& probes, int threads) {
  FollowingRun following;
  ScriptedRun& run = following.run;
  PlaceIndex nowhere;
  nowhere.fill(-1);
  const Place* place = &shelf.at(nextPlace(places, nowhere, way.front()));
  auto tissue = std::make_unique<SteppedTissue>(place->model, stateAt(place->model, way.front()), threads);
  std::unique_ptr<SteppedTissue> unchanged;  // the run without the last swap
  const int watched = static_cast<int>(std::lround(watched_seconds * places.scene.dynamics.rate_hz));
  following.substeps = place->model.substeps_per_tick;
  following.fewest_nodes = following.most_nodes = place->model.nodeCount();
  double largest = 0;
  for (std::size_t k = 0; k < way.size(); ++k) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) break;
    const PlaceIndex index = nextPlace(places, place->index, posturesAtRest(place->model, tissue->state));
    if (index != place->index) {
      const Place& next = shelf.at(index);
      const Passage passage = makePassage(*place, next);
      PassageScratch scratch(passage, tissue->state.u.size());
      State state = initialState(next.model);
      const double start = processorSeconds(CLOCK_THREAD_CPUTIME_ID);
      applyPassage(next, passage, tissue->state, scratch, state);
      Swap swap;
      swap.apply_us = 1e6 * (processorSeconds(CLOCK_THREAD_CPUTIME_ID) - start);
      swap.tick = static_cast<int>(k);
      swap.new_nodes = passage.newCount();
      swap.rows = static_cast<int>(passage.node.size());
      following.swaps.push_back(swap);
      unchanged = std::move(tissue);
      tissue = std::make_unique<SteppedTissue>(next.model, std::move(state), threads);
      place = &next;
      following.fewest_nodes = std::min(following.fewest_nodes, next.model.nodeCount());
      following.most_nodes = std::max(following.most_nodes, next.model.nodeCount());
    }
    const Vec3 force = timedTick(*tissue, way[k], run);
    largest = std::max(largest, force.norm());
    if (!unchanged) continue;
    Swap& swap = following.swaps.back();
    const Vec3 without = unchanged->tickTo(way[k]).tool_force;
    if (without.norm() > least_load * largest) {
      const double jump = (force - without).norm() / without.norm();
      if (static_cast<int>(k) == swap.tick) swap.first = jump, swap.loaded = true;
      swap.worst = std::max(swap.worst, jump);
    }
    if (static_cast<int>(k) + 1 >= swap.tick + watched) unchanged.reset();
  }
  if (!probes.empty()) run.probe_u = displacementAt(place->model, probes, tissue->state);
  return following;
}

ScriptedRun trajectoryOn(const Model& model, const ToolTrajectory& way) {
  ScriptedRun run;
  SteppedTissue tissue(model, stateAt(model, way.front()));
  for (const ToolPostures& tools : way) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) break;
    timedTick(tissue, tools, run);
  }
  return run;
}

}  // namespace palpate::tools

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

/// A state of a model that is stepped.
struct Runner {
  Runner(const Model& of, State from, int threads = 1) : model(of), state(std::move(from)), workspace(of, threads) {}

  StepReport tickTo(const Pose& pose) {
    Command command;
    command.tools[0].pose = pose;
    return tick(model, state, command, workspace);
  }

  const Model& model;
  State state;
  Workspace workspace;
};

void add(const StepReport& report, double seconds, ScriptedRun& run) {
  run.force.push_back(report.tool_force);
  run.tick_us.push_back(1e6 * seconds);
  run.flags |= report.flags;
  run.min_J = std::min(run.min_J, report.min_J);
}

void timedTick(Runner& runner, const Pose& pose, ScriptedRun& run) {
  const double start = processorSeconds(CLOCK_THREAD_CPUTIME_ID);
  const StepReport report = runner.tickTo(pose);
  add(report, processorSeconds(CLOCK_THREAD_CPUTIME_ID) - start, run);
}

State startAt(const Model& model, const Pose& pose) {
  State state = initialState(model);
  state.tool[0].pose = pose;
  return state;
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
  ToolPostures tools;
  const std::vector<ToolSpec>& specs = places.scene.tools;
  for (std::size_t t = 0; t < specs.size(); ++t) tools[t].pose.position = specs[t].position;
  tools[0].pose = way.front();
  PlaceIndex nowhere;
  nowhere.fill(-1);
  const Place* place = &shelf.at(nextPlace(places, nowhere, tools));
  auto runner = std::make_unique<Runner>(place->model, startAt(place->model, way.front()), threads);
  std::unique_ptr<Runner> unchanged;  // the run without the last swap
  const int watched = static_cast<int>(std::lround(watched_seconds * places.scene.dynamics.rate_hz));
  following.substeps = place->model.substeps_per_tick;
  following.fewest_nodes = following.most_nodes = place->model.nodeCount();
  double largest = 0;
  for (std::size_t k = 0; k < way.size(); ++k) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) break;
    const PlaceIndex index = nextPlace(places, place->index, posturesAtRest(place->model, runner->state));
    if (index != place->index) {
      const Place& next = shelf.at(index);
      const Passage passage = makePassage(*place, next);
      PassageScratch scratch(passage, runner->state.u.size());
      State state = initialState(next.model);
      const double start = processorSeconds(CLOCK_THREAD_CPUTIME_ID);
      applyPassage(next, passage, runner->state, scratch, state);
      Swap swap;
      swap.apply_us = 1e6 * (processorSeconds(CLOCK_THREAD_CPUTIME_ID) - start);
      swap.tick = static_cast<int>(k);
      swap.new_nodes = passage.newCount();
      swap.rows = static_cast<int>(passage.node.size());
      following.swaps.push_back(swap);
      unchanged = std::move(runner);
      runner = std::make_unique<Runner>(next.model, std::move(state), threads);
      place = &next;
      following.fewest_nodes = std::min(following.fewest_nodes, next.model.nodeCount());
      following.most_nodes = std::max(following.most_nodes, next.model.nodeCount());
    }
    timedTick(*runner, way[k], run);
    largest = std::max(largest, run.force.back().norm());
    if (!unchanged) continue;
    Swap& swap = following.swaps.back();
    const Vec3 without = unchanged->tickTo(way[k]).tool_force;
    if (without.norm() > least_load * largest) {
      const double jump = (run.force.back() - without).norm() / without.norm();
      if (static_cast<int>(k) == swap.tick) swap.first = jump, swap.loaded = true;
      swap.worst = std::max(swap.worst, jump);
    }
    if (static_cast<int>(k) + 1 >= swap.tick + watched) unchanged.reset();
  }
  if (!probes.empty()) run.probe_u = displacementAt(place->model, probes, runner->state);
  return following;
}

ScriptedRun trajectoryOn(const Model& model, const ToolTrajectory& way) {
  ScriptedRun run;
  Runner runner(model, startAt(model, way.front()));
  for (const Pose& pose : way) {
    run.interrupted = interrupted();
    if (run.interrupted || (run.flags & (kNotFinite | kBlowUp))) break;
    timedTick(runner, pose, run);
  }
  return run;
}

}  // namespace palpate::tools

#include "app/run/soak.h"

#include <iostream>
#include <utility>

#include "app/run/rough_motion.h"
#include "app/run/soak_places.h"
#include "io/output_file.h"

namespace palpate::app {

namespace {

constexpr int place_count = 24;
constexpr int warm_cycles = 2;
constexpr double counter_seconds = 1;  // the threads' counters are gone with them, so they are read often

double secondsSince(std::chrono::steady_clock::time_point time) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - time).count();
}

std::vector<SoakThread> countersOf(const SimulationLoop& loop) {
  std::vector<SoakThread> threads;
  for (const int id : loop.summary().rt_setup.thread_ids) threads.push_back({id, readThreadCounters(id)});
  return threads;
}

std::unique_ptr<SoakHand> handFor(const Model& model, const Places* places, bool rough, unsigned seed) {
  const int most_nodes = places ? places->nodeCount() : 0;
  if (rough) return std::make_unique<RoughMotion>(model, seed, most_nodes);
  return std::make_unique<SoakMotion>(model, soakPlaces(model, place_count, seed), seed, most_nodes);
}

}  // namespace

Soak::Soak(const Model& model, const Places* places, double minutes, bool rough, unsigned seed)
    : hand_(handFor(model, places, rough, seed)), skin_(model.skin), rate_hz_(model.scene.dynamics.rate_hz) {
  report_.rough = rough;
  // Places come and go: what is kept of them changes by as many as the worker makes ahead.
  constexpr std::int64_t of_places = 400'000'000;
  if (places) report_.memory_play = of_places;
  report_.seed = seed;
  report_.scene = model.scene.name;
  report_.state = "running";
  report_.minutes = minutes;
  report_.organ_size_m = hand_->rest().organSize();
}

void Soak::takeCycles() {
  for (SoakCycle cycle; hand_->cycles().pop(cycle);) {
    addCycle(report_, cycle);
    const double before_end = static_cast<double>(cycle.end_tick - looked_at_) / rate_hz_;
    if (before_end >= 0 && before_end < cycle.still_s)
      report_.crossings_at_rest = std::max(report_.crossings_at_rest, seen_);
    if (!cycle.rested) std::cout << unrestedLine(cycle) << std::endl;
  }
}

/// While a tool touches, or closes a fold, skin may lie on skin; alone it must not.
void Soak::lookAtSkin(const Snapshot& snapshot) {
  const double since = static_cast<double>(snapshot.tick - looked_at_) / rate_hz_;
  if (snapshot.report.isTouched() || since < crossings_seconds) return;
  if (snapshot.place) skin_.goOnWith(snapshot.place->model.skin);  // which the snapshot keeps
  seen_ = skin_.count(snapshot.u.data());
  looked_at_ = snapshot.tick;
  report_.crossings = std::max(report_.crossings, seen_);
}

void Soak::update(SimulationLoop& loop, const ResultFolder& results) {
  takeCycles();
  lookAtSkin(loop.snapshots().latest());
  if (!report_.warm && report_.cycles >= warm_cycles &&
      static_cast<double>(loop.statistics().ticks) >= warm_physics_seconds * rate_hz_)
    warmUp(loop, results);
  if (report_.warm && secondsSince(last_counters_) >= counter_seconds) countThreads(loop);
  if (secondsSince(last_report_) < interval_seconds) return;
  last_report_ = SteadyClock::now();
  measure(loop);
  write(results);
  std::cout << soakLine(report_) << std::endl;  // not into the log, which keeps its lines
}

/// Does all that the later reports do, so that they find the memory that they need.
void Soak::warmUp(SimulationLoop& loop, const ResultFolder& results) {
  measure(loop);
  write(results);
  report_.warm_physics_seconds = report_.physics_seconds;
  warm_threads_ = countersOf(loop);
  countThreads(loop);
  report_.warm = readMemoryUse();
}

void Soak::measure(SimulationLoop& loop) {
  const DeadlineStatistics& statistics = loop.statistics();
  const LoopStatus& status = loop.snapshots().latest().status;
  report_.ticks = statistics.ticks;
  report_.physics_seconds = static_cast<double>(report_.ticks) / rate_hz_;
  report_.wall_seconds = secondsSince(begin_);
  report_.realtime_factor = status.realtime_factor;
  report_.recent_realtime_factor = status.recent_realtime_factor;
  report_.frozen = status.frozen;
  report_.restored = status.restored_count;
  report_.overruns = statistics.overrun_count;
  report_.caught_up = statistics.caught_up_count;
  report_.longest_overrun_streak = statistics.longest_overrun_streak;
  for (std::size_t c = 0; c < kLateCauseCount; ++c) report_.late_ticks[c] = statistics.late_ticks[c];
  report_.step_us = statistics.step.percentiles();
  report_.wakeup_late_us = statistics.wakeup_late.percentiles();
  report_.step_bars = barsOf(statistics.step);
  report_.wakeup_late_bars = barsOf(statistics.wakeup_late);
  report_.memory = readMemoryUse();
}

/// Threads that have ended count no more: what was read last stays.
void Soak::countThreads(const SimulationLoop& loop) {
  last_counters_ = SteadyClock::now();
  std::vector<SoakThread> threads = countersOf(loop);
  if (loop.finished()) return;
  for (std::size_t t = 0; t < threads.size(); ++t)
    threads[t].counters = threads[t].counters - warm_threads_[t].counters;
  report_.threads = std::move(threads);
}

void Soak::write(const ResultFolder& results) const {
  writeWholeFile(results.soakJsonFile(), toJson(report_));
  writeWholeFile(results.soakTextFile(), toText(report_));
}

std::string Soak::finish(SimulationLoop& loop, const ResultFolder& results, bool interrupted) {
  takeCycles();
  report_.state = interrupted ? "interrupted" : "done";
  measure(loop);
  report_.flags |= loop.summary().flags;
  // With the cycle that was not ended.
  report_.peak_force_N = std::max(report_.peak_force_N, loop.summary().peak_force);
  report_.min_J = std::min(report_.min_J, loop.summary().min_J);
  report_.frozen = loop.summary().frozen;
  report_.restored = loop.summary().restored_count;
  report_.restores = loop.summary().restores;
  report_.let_go = loop.summary().let_go_count;
  report_.largest_yield_m = loop.summary().largest_yield;
  report_.realtime_factor = loop.summary().totals.realtime_factor;
  write(results);
  std::cout << toText(report_) << std::flush;
  std::string broken;
  for (const std::string& promise : brokenPromises(report_)) broken += (broken.empty() ? "" : "; ") + promise;
  return broken;
}

}  // namespace palpate::app

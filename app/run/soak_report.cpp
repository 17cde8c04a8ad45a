#include "app/run/soak_report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/number_text.h"
#include "realtime/recording/run_report.h"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBinsPerBar = (1 << DurationHistogram::kSubBits) / 4;
constexpr int kLongestBar = 50;  // characters

double kB(std::int64_t bytes) { return static_cast<double>(bytes) / 1024; }

Json barsJson(const std::vector<HistogramBar>& bars) {
  Json json = Json::array();
  for (const HistogramBar& bar : bars) json.push_back(Json::array({bar.begin_us, bar.end_us, bar.count}));
  return json;
}

std::string barsText(const char* title, const std::vector<HistogramBar>& bars, const Percentiles& p) {
  std::string text =
      format("%s: p50 %.1f, p99 %.1f, p99.9 %.1f, longest %.1f us\n", title, p.p50, p.p99, p.p999, p.max);
  std::int64_t most = 1;
  for (const HistogramBar& bar : bars) most = std::max(most, bar.count);
  for (const HistogramBar& bar : bars) {
    // Logarithmic: a single late tick among a million must show.
    const double share = std::log1p(static_cast<double>(bar.count)) / std::log1p(static_cast<double>(most));
    text += format("%10.1f us %12lld ", bar.begin_us, asLongLong(bar.count)) +
            std::string(static_cast<std::size_t>(std::lround(kLongestBar * share)), '#') + "\n";
  }
  return text;
}

std::string memoryText(const SoakReport& r) {
  if (!r.warm) return "still warming up";
  return format("%+.0f kB", kB(r.memoryGrowth()));
}

/// Where something happened more often than the limit, per 10^6 ticks, allows.
void addExcess(const char* what, std::int64_t count, double limit, std::int64_t ticks,
               std::vector<std::string>& broken) {
  const double allowed = 1 + 1e-6 * limit * static_cast<double>(ticks);
  if (static_cast<double>(count) > allowed)
    broken.push_back(format("%s %lld times in %lld ticks (limit %.0f)", what, asLongLong(count), asLongLong(ticks),
                            std::floor(allowed)));
}

}  // namespace

std::vector<HistogramBar> barsOf(const DurationHistogram& histogram) {
  std::vector<HistogramBar> bars;
  for (int b = 0; b < DurationHistogram::kBinCount; b += kBinsPerBar) {
    HistogramBar bar{DurationHistogram::binBeginUs(b), DurationHistogram::binBeginUs(b + kBinsPerBar), 0};
    for (int k = b; k < b + kBinsPerBar; ++k) bar.count += histogram.binCount(k);
    if (bar.count > 0 || !bars.empty()) bars.push_back(bar);
  }
  while (!bars.empty() && bars.back().count == 0) bars.pop_back();
  return bars;
}

void addCycle(SoakReport& report, const SoakCycle& cycle) {
  ++report.cycles;
  report.unrested_cycles += !cycle.rested;
  if (!cycle.rested) report.unrested_speed = std::max(report.unrested_speed, cycle.rest_speed);
  report.longest_rest_s = std::max(report.longest_rest_s, cycle.rest_s);
  report.drift_m = cycle.drift_m;
  report.largest_drift_m = std::max(report.largest_drift_m, cycle.drift_m);
  report.peak_force_N = std::max(report.peak_force_N, cycle.peak_force_N);
  report.min_J = std::min(report.min_J, cycle.min_J);
  report.flags |= cycle.flags;
  report.not_finite += cycle.not_finite;
}

std::vector<std::string> brokenPromises(const SoakReport& r) {
  std::vector<std::string> broken;
  const std::uint32_t fatal = kNotFinite | (r.rough ? 0u : kBlowUp);
  if (r.frozen || (r.flags & fatal) != 0 || (r.restored > 0 && !r.rough) || !std::isfinite(r.drift_m) ||
      !std::isfinite(r.peak_force_N))
    broken.push_back("the state did not stay finite");
  if (r.rough) {
    addExcess("the tissue was lost and was put back", r.restores.lost, RoughLimits::lost, r.ticks, broken);
    addExcess("the tissue folded and was put back", r.restores.folded, RoughLimits::folded, r.ticks, broken);
    addExcess("the tool was stuck and let go", r.let_go, RoughLimits::let_go, r.ticks, broken);
    if (r.crossings > RoughLimits::crossings)
      broken.push_back(format("the skin crosses itself at %d places (limit %d)", r.crossings, RoughLimits::crossings));
    if (r.crossings_at_rest > RoughLimits::crossings_at_rest)
      broken.push_back(format("at rest the skin crosses itself at %d places", r.crossings_at_rest));
  }
  if (r.memoryGrowth() > r.memory_play)
    broken.push_back(format("memory grew by %.0f kB after the warm-up", kB(r.memoryGrowth())));
  if (r.rough && r.largest_drift_m > RestWatch::rough_drift_limit_m)
    broken.push_back(format("the state at rest drifted by %.2g m (limit %.0e m)", r.largest_drift_m,
                            RestWatch::rough_drift_limit_m));
  if (!r.rough && r.drift() > RestWatch::drift_limit)
    broken.push_back(format("the state at rest drifted by %.2g of the organ's size (limit %.0e)", r.drift(),
                            RestWatch::drift_limit));
  if (r.cycles == 0) broken.push_back("no cycle came to its end, and rest was never looked at: a longer soak");
  if (r.unrested_cycles > 0)
    broken.push_back(
        format("after %lld of %lld cycles the tissue was still moving %.0f s later, by up to %.1e m/s at a node: too "
               "little damping, or rounding that never settles",
               asLongLong(r.unrested_cycles), asLongLong(r.cycles), RestWatch::longest_rest_s, r.unrested_speed));
  return broken;
}

std::string unrestedLine(const SoakCycle& c) {
  return format("cycle %lld, tick %lld: not at rest after %.0f s, fastest node %.1e m/s, %.1e m off, min J %.3f",
                asLongLong(c.number), asLongLong(c.end_tick), c.rest_s, c.rest_speed, c.drift_m,
                static_cast<double>(c.min_J));
}

std::string soakLine(const SoakReport& r) {
  return format(
             "%.1f min: %lld cycles, real time x%.4f, step p99.9 %.0f us, %lld overruns, drift %.1e, min J %.3f, %lld "
             "restored, ",
             r.physics_seconds / 60, asLongLong(r.cycles), r.realtime_factor, r.step_us.p999, asLongLong(r.overruns),
             r.drift(), static_cast<double>(r.min_J), asLongLong(r.restored)) +
         "memory " + memoryText(r);
}

std::string toJson(const SoakReport& r) {
  Json threads = Json::array();
  for (const SoakThread& t : r.threads) {
    threads.push_back({{"id", t.id},
                       {"minor_faults", t.counters.minor_faults},
                       {"major_faults", t.counters.major_faults},
                       {"voluntary_switches", t.counters.voluntary_switches},
                       {"involuntary_switches", t.counters.involuntary_switches}});
  }
  const auto memory = [](const MemoryUse& m) { return Json{{"resident", m.resident}, {"anonymous", m.anonymous}}; };
  const Json json = {
      {"scene", r.scene},
      {"state", r.state},
      {"broken_promises", brokenPromises(r)},
      {"minutes", r.minutes},
      {"physics_seconds", r.physics_seconds},
      {"wall_seconds", r.wall_seconds},
      {"realtime_factor", r.realtime_factor},
      {"recent_realtime_factor", r.recent_realtime_factor},
      {"ticks", r.ticks},
      {"overruns", r.overruns},
      {"caught_up", r.caught_up},
      {"longest_overrun_streak", r.longest_overrun_streak},
      {"late_ticks", lateTicksJson(r.late_ticks)},
      {"step_us", percentilesJson(r.step_us)},
      {"wakeup_late_us", percentilesJson(r.wakeup_late_us)},
      {"step_histogram", barsJson(r.step_bars)},
      {"wakeup_late_histogram", barsJson(r.wakeup_late_bars)},
      {"cycles", r.cycles},
      {"unrested_cycles", r.unrested_cycles},
      {"longest_rest_s", r.longest_rest_s},
      {"organ_size_m", r.organ_size_m},
      {"drift_m", r.drift_m},
      {"drift", r.drift()},
      {"largest_drift_m", r.largest_drift_m},
      {"peak_force_N", r.peak_force_N},
      {"min_J", r.min_J},
      {"flags", flagNames(r.flags)},
      {"rough", r.rough},
      {"seed", r.seed},
      {"freezes", r.frozen ? 1 : 0},
      {"restored", r.restored},
      {"restores", {{"lost", r.restores.lost}, {"folded", r.restores.folded}}},
      {"let_go", r.let_go},
      {"skin_crossings", r.crossings},
      {"skin_crossings_at_rest", r.crossings_at_rest},
      {"not_finite_ticks", r.not_finite},
      {"largest_yield_m", r.largest_yield_m},
      {"frozen", r.frozen},
      {"warm_physics_seconds", r.warm_physics_seconds},
      {"memory_warm", r.warm ? memory(*r.warm) : Json()},
      {"memory", memory(r.memory)},
      {"memory_growth", r.warm ? Json(r.memoryGrowth()) : Json()},
      {"threads_since_warm_up", threads},
  };
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string toText(const SoakReport& r) {
  std::string text = format("soak of %s, %s: %.1f of %.1f min of physics in %.1f min\n", r.scene.c_str(),
                            r.state.c_str(), r.physics_seconds / 60, r.minutes, r.wall_seconds / 60);
  for (const std::string& broken : brokenPromises(r)) text += "BROKEN: " + broken + "\n";
  text += soakLine(r) + "\n";
  text +=
      format("rest: longest wait %.2f s, drift at last %.2e m, at most %.2e m, of an organ of %.3f m; %lld unrested\n",
             r.longest_rest_s, r.drift_m, r.largest_drift_m, r.organ_size_m, asLongLong(r.unrested_cycles));
  text += format("%s hand, seed %u: %d freezes, %lld times restored, %lld ticks not finite; it yielded by %.1f mm\n",
                 r.rough ? "rough" : "careful", r.seed, r.frozen ? 1 : 0, asLongLong(r.restored),
                 asLongLong(r.not_finite), 1e3 * r.largest_yield_m);
  text += format(
      "put back: %lld lost, %lld folded; %lld times the tool let go; skin crosses itself at %d places at "
      "most, "
      "at rest at %d\n",
      asLongLong(r.restores.lost), asLongLong(r.restores.folded), asLongLong(r.let_go), r.crossings,
      r.crossings_at_rest);
  std::string flags;
  for (const std::string& name : flagNames(r.flags)) flags += " " + name;
  text += format("peak force %.3f N, min J %.3f, flags:", r.peak_force_N, static_cast<double>(r.min_J)) +
          (flags.empty() ? " none" : flags) + "\n";
  text += format(
      "ticks %lld, overruns %lld (%lld made good), longest streak %lld; late ticks: %lld woken late, %lld core taken, "
      "%lld worker late, %lld long computation\n",
      asLongLong(r.ticks), asLongLong(r.overruns), asLongLong(r.caught_up), asLongLong(r.longest_overrun_streak),
      asLongLong(r.late_ticks[0]), asLongLong(r.late_ticks[1]), asLongLong(r.late_ticks[2]),
      asLongLong(r.late_ticks[3]));
  text += format("memory: %.0f kB anonymous, %.0f kB resident; since the warm-up (%.0f s of physics): ",
                 kB(r.memory.anonymous), kB(r.memory.resident), r.warm_physics_seconds) +
          memoryText(r) + "\n";
  for (const SoakThread& t : r.threads)
    text += format(
        "thread %d since the warm-up: %lld minor and %lld major page faults, %lld voluntary and %lld "
        "involuntary switches\n",
        t.id, asLongLong(t.counters.minor_faults), asLongLong(t.counters.major_faults),
        asLongLong(t.counters.voluntary_switches), asLongLong(t.counters.involuntary_switches));
  text += barsText("step", r.step_bars, r.step_us) + barsText("wake-up late", r.wakeup_late_bars, r.wakeup_late_us);
  return text;
}

}  // namespace palpate::app

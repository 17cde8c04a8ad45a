// What the panels show of a session.
#include <algorithm>
#include <string_view>

#include "app/run/session.h"
#include "mechanics/materials/material_law.h"

namespace palpate::app {
namespace {

constexpr double most_times_stiffer = 4;  // than the scene, live
constexpr double largest_poisson = 0.4995;

SetupLine setupLine(const char* name, const std::string& outcome) {
  const std::string done = "done: ", refused = "not done: ";
  if (outcome.starts_with(done)) return {name, outcome.substr(done.size()), true};
  if (outcome.starts_with(refused)) return {name, "no: " + outcome.substr(refused.size()), false};
  return {name, outcome, false};
}

MaterialView mixedView(const MaterialSpec& spec, std::size_t mixtures) {
  MaterialView view;
  view.name = spec.name;
  view.material = spec.material;
  view.mixtures = static_cast<int>(mixtures);
  return view;
}

}  // namespace

ForceHistory Session::forcesUntil(const Snapshot& past) const {
  ForceHistory history(forces_.seconds());
  const auto first = std::upper_bound(samples_.begin(), samples_.end(), past.status.reset_tick,
                                      [](std::int64_t tick, const ForceSample& sample) { return tick < sample.tick; });
  for (auto sample = first; sample != samples_.end() && sample->tick <= past.force.tick; ++sample) history.add(*sample);
  return history;
}

TimingView Session::timing(const Snapshot& snapshot) const {
  constexpr int bar_count = 80;
  const DeadlineStatistics& statistics = loop_->statistics();
  const Percentiles step = statistics.step.percentiles(), late = statistics.wakeup_late.percentiles();
  TimingView view;
  view.rate_hz = scene_.dynamics.rate_hz;
  view.threads = physics_->team().size();
  view.step_p50 = step.p50;
  view.step_p99 = step.p99;
  view.step_p999 = step.p999;
  view.step_max = step.max;
  view.late_p99 = late.p99;
  view.late_max = late.max;
  view.histogram_end = std::max(1.1e6 / scene_.dynamics.rate_hz, 1.1 * step.p999);
  view.histogram.assign(bar_count, 0.0F);
  for (int b = 0; b < DurationHistogram::kBinCount; ++b) {
    const std::int64_t count = statistics.step.binCount(b);
    if (count == 0) continue;
    const double middle = 0.5 * (DurationHistogram::binBeginUs(b) + DurationHistogram::binEndUs(b));
    const int bar = std::min(bar_count - 1, static_cast<int>(bar_count * middle / view.histogram_end));
    view.histogram[static_cast<std::size_t>(bar)] += static_cast<float>(count);
  }
  // The loop's thread has set itself up before it publishes its first tick.
  if (snapshot.status.ticks > 0) {
    const RtSetup& setup = loop_->summary().rt_setup;
    view.setup = {setupLine("Scheduling", setup.scheduling), setupLine("Memory lock", setup.memory_lock),
                  setupLine("Affinity", setup.affinity), setupLine("Denormals", setup.denormals)};
  }
  return view;
}

/// How far the time step lets a material go is asked of the physics itself.
MaterialView Session::materialView(std::size_t index) const {
  const Material& loaded = scene_materials_[index];
  MaterialView view;
  view.name = scene_.materials[index].name;
  view.material = materials_[index];
  view.stiffness = view.material.shear_modulus / loaded.shear_modulus;
  const auto most = [&](double low, double high, const auto& made) {  // the largest value that is taken, by bisection
    const auto taken = [&](double value) { return physics_->excessOf(static_cast<int>(index), made(value)) <= 0; };
    if (taken(high)) return high;
    for (int k = 0; k < 24; ++k) (taken(0.5 * (low + high)) ? low : high) = 0.5 * (low + high);
    return low;
  };
  view.most_stiffness = most(0, most_times_stiffer, [&](double s) { return stiffened(loaded, s); });
  const auto& parameters = loaded.lawDescription().parameters;
  const auto has = [&](std::string_view name) {
    return std::any_of(parameters.begin(), parameters.end(), [&](const Parameter& p) { return name == p.name; });
  };
  view.elastic_constants = has("young") && has("poisson");
  if (!view.elastic_constants) return view;
  const auto with = [&](const char* name) {
    return [&material = view.material, name](double value) { return Material(material).set(name, value); };
  };
  view.scene_young = loaded.get("young")[0];
  view.most_young = most(0, most_times_stiffer * loaded.get("young")[0], with("young"));
  view.most_poisson = most(0, largest_poisson, with("poisson"));
  return view;
}

PanelData Session::panelData(const Snapshot& snapshot) const {
  PanelData data{.model = modelOf(snapshot, model_), .snapshot = snapshot, .forces = forces_, .log = log_.lines()};
  data.timing = timing(snapshot);
  // Old is what was old when it was taken, and not what took long to draw. Pictures of a moment, off-screen, after the
  // end or of the past, show its force as it was then.
  const bool present = &snapshot == latest_ && !ended_ && !options_.offscreen;
  data.force =
      present ? readForce(snapshot.force, latest_ns_, scene_.dynamics.rate_hz) : ForceReading{snapshot.force, 0, true};
  // Mixtures of tissue are hundreds of materials; one of them alone is nothing to change.
  const bool mixes = materials_.size() != scene_.materials.size();
  for (std::size_t m = 0; m < scene_.materials.size(); ++m)
    data.materials.push_back(mixes ? mixedView(scene_.materials[m], materials_.size()) : materialView(m));
  data.friction = friction_;
  data.driver = driver();
  data.script = script_;
  if (searching()) data.input_note = "a search is made with what the scene says";
  if (data.driver == ToolDriver::Script) data.input_note = "a script runs, which must find the scene's own values";
  if (data.driver == ToolDriver::Replay) data.input_note = "a recording runs, which brings its own values";
  const auto isStiffAs = [](const Material& a, const Material& b) {
    return std::equal(std::begin(a.value), std::end(a.value), std::begin(b.value));
  };
  if (certified_ && certified_->holds(snapshot.force.tick) && friction_ == scene_.tools[0].friction &&
      std::equal(materials_.begin(), materials_.end(), scene_materials_.begin(), isStiffAs)) {
    const Certificate& certificate = certified_->certificate();
    data.certified = certifiedText(certificate, snapshot.force.advance_m);
    if (const Certificate::Row* row = certificate.at(snapshot.force.advance_m)) data.certified_error = row->bound();
  }
  data.frozen_reason = frozen_reason_;
  data.task = task();
  data.revealed = revealed_;
  if (revealed_) data.conditions = conditions().text();
  data.notice = notice_;
  if (!options_.offscreen) data.presses = &presses_;
  return data;
}

}  // namespace palpate::app

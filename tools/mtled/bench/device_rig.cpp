#include "mtled/bench/device_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "discretization/surface/solids.h"
#include "io/find_asset.h"
#include "io/load_model.h"
#include "io/scene_file.h"
#include "realtime/device/device_thread.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate::tools {
namespace {

constexpr std::int64_t kDeviceNs = 1'000'000;
constexpr double kTickShare = 0.8;  // of the period, that a tick takes: the force is no younger
// Of a press of 4 s, from where all is at rest to where it is measured, and when the silence begins in the next.
constexpr double kRestFrom = 1.3, kRestTo = 2.3, kStaticFrom = 2.0, kSilent = 5.6, kSilence = 0.2;
constexpr double kGapsFrom = 1.5, kGapEvery = 0.5;

/// 50 kPa, 8 mm below the top of a soft block.
Scene inclusionScene() {
  Scene scene;
  scene.name = "inclusion";
  scene.organs[0].solid = OrganSpec::Solid::Box;
  scene.organs[0].size = Vec3(0.08, 0.08, 0.04);
  scene.discretization.spacing = 0.009;
  scene.materials.emplace_back();
  scene.materials[0].material.set("young", 5000);
  scene.materials[0].material.set("poisson", 0.45);
  MaterialSpec& ball = scene.materials.emplace_back(scene.materials[0]);
  ball.material.set("young", 50000);
  ball.everywhere = false;
  ball.region.kind = Region::Kind::Sphere;
  ball.region.point = Vec3(0, 0, 0.026);
  ball.region.radius = 0.010;
  BoundarySpec base;
  base.region.kind = Region::Kind::NearPlane;
  base.region.distance = 1e-6;
  scene.boundaries.push_back(base);
  scene.dynamics.damping = 40;
  scene.tools[0].shape.radius = 0.008;
  scene.tools[0].position = Vec3(0, 0, 0.043);
  return scene;
}

/// 20 mm of one material, bonded below; the tool begins 3 mm above it.
Scene slabScene() {
  Scene scene = inclusionScene();
  scene.name = "slab";
  scene.organs[0].size = Vec3(0.06, 0.06, 0.02);
  scene.discretization.spacing = 0.008;
  scene.materials.resize(1);
  scene.materials[0].material.set("young", 50000);
  scene.tools[0].shape.radius = 0.006;
  scene.tools[0].position = Vec3(0, 0, 0.023);
  return scene;
}

/// Time as the trial has it, and what is under way between the loop and the device's thread.
class Lockstep {
 public:
  Lockstep(const Model& model, const DeviceTrial& trial, const HandMotion& motion)
      : model_(model),
        tick_ns_(std::llround(1e9 / model.scene.dynamics.rate_hz)),
        device_(deviceOf(trial), trial.hand.value_or(trial.firm ? HandModel::firm() : HandModel::light()), motion),
        tool_(model),
        link_(device_, tool_, model),
        physics_(model, 1),
        loop_(model, physics_, nullptr, optionsFor(tool_)) {}

  /// One look of the device's thread, and the loop's ticks that begin until the next.
  /// @param stalled  no tick begins: something else has the loop's core
  void advance(bool stalled) {
    link_.exchange(now_, ready_);
    arrivals_.emplace_back(link_.wrench().answers, now_);
    for (; next_tick_ < now_ + kDeviceNs; next_tick_ += tick_ns_) {
      if (stalled) continue;
      if (next_tick_ >= done_ns_ && pending_.tick > 0) ready_ = pending_;
      loop_.advanceHere(1);
      pending_ = loop_.force().sample;
      pending_.wall_ns = next_tick_;
      done_ns_ = next_tick_ + static_cast<std::int64_t>(kTickShare * static_cast<double>(tick_ns_));
      judgeLatency();
    }
    now_ += kDeviceNs;
    if (now_ >= done_ns_) ready_ = pending_;
  }

  double seconds() const { return 1e-9 * static_cast<double>(now_ - kBegin); }
  SimulatedDevice& device() { return device_; }
  const DeviceLink& link() const { return link_; }
  const ForceSample& tissue() const { return pending_; }
  const Pose& target() { return tool_.targets().latest().pose; }
  double latency_ticks = 0;

 private:
  static SimulatedDeviceSettings deviceOf(const DeviceTrial& trial) {
    if (trial.device) return *trial.device;
    SimulatedDeviceSettings settings = SimulatedDeviceSettings::of(trial.device_class);
    settings.delay_s = trial.delay_s;
    settings.seed = trial.seed;
    return settings;
  }
  static SimulationLoopOptions optionsFor(CoupledTool& tool) {
    SimulationLoopOptions options;
    options.force_capacity = 1;
    options.device = &tool;
    return options;
  }

  /// How long the oldest pose that this tick is the first to answer has waited for its force.
  void judgeLatency() {
    const auto answered = std::find_if(arrivals_.begin(), arrivals_.end(),
                                       [&](const auto& a) { return a.first > pending_.pose_sequence; });
    // Only the newest of them is answered; those before it were overtaken, as the latest wins.
    if (answered != arrivals_.begin() && pending_.pose_sequence > last_answered_) {
      const auto first =
          std::find_if(arrivals_.begin(), answered, [&](const auto& a) { return a.first == pending_.pose_sequence; });
      if (first != answered)
        latency_ticks =
            std::max(latency_ticks, static_cast<double>(done_ns_ - first->second) / static_cast<double>(tick_ns_));
    }
    arrivals_.erase(arrivals_.begin(), answered);
    last_answered_ = pending_.pose_sequence;
  }

  static constexpr std::int64_t kBegin = 1'000'000'000;
  const Model& model_;
  const std::int64_t tick_ns_;
  SimulatedDevice device_;
  CoupledTool tool_;
  DeviceLink link_;
  TissuePhysics physics_;
  SimulationLoop loop_;
  std::int64_t now_ = kBegin, next_tick_ = kBegin, done_ns_ = 0;
  ForceSample pending_, ready_;
  std::vector<std::pair<std::uint64_t, std::int64_t>> arrivals_;  // of poses: sequence, ns
  std::uint64_t last_answered_ = 0;
};

/// Forces and ways at rest.
struct Rest {
  Vec3 handle = Vec3::Zero(), tissue = Vec3::Zero();
  double tool_depth = 0, handle_depth = 0;
  int count = 0;
};

void judgeRest(const Rest& rest, DeviceResult& result) {
  if (rest.count == 0 || rest.tissue.isZero(0)) return;
  const double n = rest.count, force = rest.tissue.norm() / n;
  result.static_force = force;
  result.static_error = (rest.handle - rest.tissue).norm() / rest.tissue.norm();
  if (rest.tool_depth > 0) result.tissue_stiffness = force / (rest.tool_depth / n);
  if (rest.handle_depth > 0) result.felt_stiffness = rest.handle.norm() / rest.handle_depth;
}

}  // namespace

std::pair<double, double> spectralPeak(const std::vector<Vec3>& force, double rate_hz, double from_hz) {
  const std::size_t n = force.size();
  if (n < 2) return {0, 0};
  Vec3 mean = Vec3::Zero();
  for (const Vec3& f : force) mean += f / static_cast<double>(n);
  const Vec3 along = mean.isZero(0) ? Vec3(Vec3::UnitZ()) : Vec3(mean.normalized());
  std::pair<double, double> peak{0, 0};
  const double step = rate_hz / static_cast<double>(n);
  for (double hz = std::ceil(from_hz / step) * step; hz <= 0.5 * rate_hz; hz += step) {
    double re = 0, im = 0, sum = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const double t = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
      const double window = 0.5 - 0.5 * std::cos(t), value = window * (force[k] - mean).dot(along);
      re += value * std::cos(t * hz / step);
      im += value * std::sin(t * hz / step);
      sum += window;
    }
    const double amplitude = 2 * std::hypot(re, im) / sum;
    if (amplitude > peak.first) peak = {amplitude, hz};
  }
  return peak;
}

DeviceResult runDeviceTrial(const Model& model, const DeviceTrial& trial) {
  const Vec3 down = model.tools.first().start.pose.orientation * -Vec3::UnitZ();
  HandMotion motion;
  motion.kind = trial.motion;
  motion.down = down;
  motion.along = model.tools.first().start.pose.orientation * Vec3::UnitX();
  motion.depth = model.tools.first().first_contact_travel + 1.0 * model.scene.tools[0].shape.radius + trial.deeper;
  motion.rock = trial.rock;
  motion.slide = 0.4 * model.scene.tools[0].shape.radius;
  motion.seed = trial.seed;
  const bool press = trial.motion == HandMotion::Kind::Press;

  Lockstep run(model, trial, motion);
  DeviceResult result;
  std::vector<Vec3> steady;
  Rest rest;
  double before = 0, dragged = 0, moved = 0, before_gap = 0;
  Vec3 handle = run.device().handle();
  while (run.seconds() < trial.seconds) {
    const double t = run.seconds(), since = t - kSilent;
    const double gap = std::fmod(t, kGapEvery);
    const auto gaps = [&](int count) {
      return t >= kGapsFrom && t < kGapsFrom + kGapEvery * count && gap < trial.lasting;
    };
    if (gap < 1e-9 * kDeviceNs) before_gap = run.device().work();
    run.device().setSilent((press && since >= 0 && since < kSilence) || gaps(trial.dropouts));
    run.advance(gaps(trial.stalls));
    if (t >= kGapsFrom && t < kGapsFrom + kGapEvery * std::max(trial.dropouts, trial.stalls))
      result.dropout_J = std::max(result.dropout_J, run.device().work() - before_gap);
    result.pull = std::max(result.pull, run.device().force().dot(down));
    const Vec3& force = run.link().wrench().force;
    result.peak_force = std::max(result.peak_force, force.norm());
    const Vec3 v = (run.device().handle() - handle) / (1e-9 * kDeviceNs);
    handle = run.device().handle();
    if (run.tissue().contact_count > 0 && t > 0.3 && since < 0) {
      dragged -= (force - run.tissue().force_raw).dot(v);
      moved += v.squaredNorm();
    }
    result.given_J = std::max(result.given_J, run.device().work());
    if (press ? t >= kRestFrom && t < kRestTo : t >= 0.5) steady.push_back(force);
    if (press && t >= kStaticFrom && t < kRestTo) {
      rest.handle += force;
      rest.tissue += run.tissue().force_raw;
      rest.tool_depth += run.tissue().advance_m;
      rest.handle_depth += (run.target().position - model.tools.first().start.pose.position).dot(down) -
                           model.tools.first().first_contact_travel;
      ++rest.count;
    }
    if (!press || since < -0.05) continue;
    if (since < 0) before = std::max(before, force.norm());
    if (since >= 0 && since < kSilence && !force.isZero(0)) result.silence_ms = 1e3 * (since + 1e-9 * kDeviceNs);
    if (since >= kSilence && since < kSilence + 0.05 && before > 0)
      result.blow = std::max(result.blow, force.norm() / before);
  }
  const DeviceReport report = run.link().report();
  result.lowest_energy_J = report.lowest_energy_J;
  result.damped_J = report.damped_J;
  result.peak_torque = report.peak_torque;
  result.coupling_stiffness = report.stiffness;
  if (moved > 0) result.drag = dragged / moved;
  result.latency_ticks = run.latency_ticks;
  result.frozen = run.tissue().frozen || run.tissue().loss_count > 0;
  const auto [amplitude, hz] = spectralPeak(steady, 1e9 / kDeviceNs, 20);
  if (result.peak_force > 0) result.limit_cycle = amplitude / result.peak_force;
  result.limit_cycle_hz = hz;
  judgeRest(rest, result);
  return result;
}

Model deviceBody(const std::string& body) {
  if (body == "inclusion" || body == "slab") {
    const Scene scene = body == "slab" ? slabScene() : inclusionScene();
    return buildModel(scene, boxSurface(scene.organs[0].size, 0.004));
  }
  const bool liver = body == "liver";
  const std::vector<SceneChange> changes{{"discretization.spacing", liver ? "0.014" : "0.0045"},
                                         {"dynamics.threads", "1"}};
  return loadModel(readScene(findScene(liver ? "liver" : "gel_cylinder"), changes));
}

}  // namespace palpate::tools

#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "base/key.h"
#include "realtime/loop/physics.h"
#include "realtime/timing/fixed_step_loop.h"

namespace palpate::test {

/// Time that passes only when told to.
class FakeClock final : public Clock {
 public:
  std::int64_t time = 1'000'000'007;  // ns; no multiple of any period
  std::int64_t late = 0;              // ns, how late sleepers wake
  int sleeps = 0;
  std::int64_t away = 0;  // ns of `time` in which the thread did not run
  ThreadUse use;
  std::function<void(int)> before_sleep;  // called with the number of sleeps before

  std::int64_t now() override { return time; }
  void sleepUntil(std::int64_t until) override {
    if (before_sleep) before_sleep(sleeps);
    ++sleeps;
    if (until > time) {
      away += until + late - time;
      time = until + late;
    }
  }
  std::int64_t threadCpu() override { return time - away; }
  ThreadUse threadUse() override { return use; }
};

/// The real clock; does something once, before the first sleep.
class ClockWithStart final : public Clock {
 public:
  explicit ClockWithStart(void (*at_start)()) : at_start_(at_start) {}
  std::int64_t now() override { return clock_.now(); }
  void sleepUntil(std::int64_t time) override {
    if (at_start_ != nullptr) at_start_();
    at_start_ = nullptr;
    clock_.sleepUntil(time);
  }
  std::int64_t threadCpu() override { return clock_.threadCpu(); }
  ThreadUse threadUse() override { return clock_.threadUse(); }

 private:
  MonotonicClock clock_;
  void (*at_start_)();
};

/// A model with just what the loop reads: 4 nodes, 3 points, a tool that points down.
inline Model smallModel(double rate_hz = 500) {
  Model model;
  model.scene.name = "small";
  model.scene.dynamics.rate_hz = rate_hz;
  model.scene.dynamics.catch_up = 0;  // what is late is skipped, unless a test is about that
  model.scene.tools[0].friction = model.tools.first().friction = 0.1;
  model.scene.force.cutoff_hz = 30;
  model.scene.force.rate_limit = 200;
  model.X = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.02, 0}, {0, 0, 0.03}};
  model.point_X = {{0.001, 0.002, 0.003}, {0.004, 0.005, 0.006}, {0.007, 0.008, 0.009}};
  model.point_volume = {1e-6, 1e-6, 1e-6};
  model.materials = {Material{}};
  model.materials[0].shear_modulus = 1000;
  model.materials[0].bulk_modulus = 50000;
  model.inverse_mass = {1, 2, 3, 4};
  model.mass = {1, 0.5, 1.0 / 3, 0.25};
  model.skin.surface.vertices = {{0, 0, 0}, {0.01, 0, 0}};
  model.tools.first().start.pose.position = Vec3(0, 0, 0.1);
  model.tools.first().first_contact_travel = 0.02;
  model.dt = 1 / rate_hz / 4;
  model.dt_critical = model.dt * 1.6;
  model.substeps_per_tick = 4;
  return model;
}

/// A Physics whose state depends, bit for bit, on every command since the last reset:
/// each node is a chaotic map, kicked by the tool, the pull, friction and stiffness.
class FakePhysics final : public Physics {
 public:
  explicit FakePhysics(const Model& model) : friction(model.scene.tools[0].friction) {
    initial_.u.resize(model.X.size());
    for (std::size_t i = 0; i < initial_.u.size(); ++i) initial_.u[i].x = 0.1F + 0.1F * static_cast<float>(i);
    initial_.tool[0].pose = model.tools.first().start.pose;
    initial_.live.kernel.materials = model.materials;
    initial_.contact[0].vertex.assign(4, -1);
    initial_.contact[0].force.assign(4, Float4{});
    initial_.contact[0].normal.assign(4, -Vec3f::UnitZ());
    state_ = initial_;
  }

  std::function<void(State&, StepReport&)> on_tick;  // may spoil the outcome
  std::function<void(double)> on_friction;           // told of each change
  double friction;
  double stiffness = 1;
  double force_per_m = 100;  // N/m along z below the start
  int calls = 0;
  Command last_command;

  StepReport tick(const Command& command) override {
    ++calls;
    last_command = command;
    ++state_.tick;
    state_.tool[0].pose = command.tools[0].pose;
    const Vec3& p = command.tools[0].pose.position;
    const Vec3 kick = p + friction * Vec3(0.3, 0.2, 0.1) +
                      (command.pull_vertex >= 0 ? command.pull_target : Vec3::Zero()) +
                      0.01 * stiffness * command.tools[0].pose.orientation.coeffs().head<3>();
    for (Float4& u : state_.u) {
      u.x = 3.7F * u.x * (1 - u.x);
      u.y = 0.9F * u.y + static_cast<float>(kick.x() + 2 * kick.y()) * u.x;
      u.z = 0.9F * u.z + static_cast<float>(stiffness * kick.z()) * u.x;
    }
    StepReport report;
    report.tool_force = Vec3(0, 0, force_per_m * (initial_.tool[0].pose.position.z() - p.z()));
    report.loads[0].force = report.tool_force;
    report.base_reaction = -report.tool_force;
    report.min_J = 0.9F;
    state_.contact[0].count = 2;
    state_.contact[0].vertex[0] = 1;
    state_.contact[0].vertex[1] = 0;
    state_.contact[0].force[0] = toFloat4(-report.tool_force);
    if (on_tick) on_tick(state_, report);
    return report;
  }

  const State& state() const override { return state_; }
  std::uint64_t stateHash() const override {
    const auto bytesOf = [](const auto& value) {
      return std::string_view(reinterpret_cast<const char*>(&value), sizeof value);
    };
    std::uint64_t hash = fnv1a(bytesOf(state_.tick));
    for (const Float4& u : state_.u) hash = fnv1a(bytesOf(u), hash);
    return fnv1a(bytesOf(state_.tool[0].pose.position), hash);
  }
  void reset() override { state_ = initial_; }
  void restore(const State& past) override { state_ = past; }
  void setFriction(int, double coefficient) override {
    friction = coefficient;
    if (on_friction) on_friction(coefficient);
  }
  double setMaterial(int, const Material& material) override {
    const double excess = material.shear_modulus / 2000;
    if (excess > 1) return excess;
    stiffness = material.shear_modulus / 1000;
    return 0;
  }

 private:
  State initial_, state_;
};

}  // namespace palpate::test

#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "realtime/device/coupled_tool.h"
#include "realtime/device/device_backend.h"
#include "realtime/device/device_coupling.h"
#include "realtime/loop/simulation_loop.h"

namespace palpate {

/// One exchange with a device: its newest pose in, the coupling's force out, the tool's target on to the loop.
/// One thread. As real-time as the backend is: its own part neither allocates nor locks.
class DeviceLink {
 public:
  /// All must outlive this.
  DeviceLink(DeviceBackend& backend, CoupledTool& tool, const Model& model)
      : backend_(backend), tool_(tool), coupling_(model.scene.device, model) {}

  /// @param tool  the loop's newest tick, its wall_ns by the clock of `now`, ns
  void exchange(std::int64_t now, const ForceSample& tool);

  DeviceReport report() const { return coupling_.report(); }
  const DeviceCoupling& coupling() const { return coupling_; }
  /// What went out last.
  const DeviceWrench& wrench() const { return wrench_; }

 private:
  DeviceBackend& backend_;
  CoupledTool& tool_;
  DeviceCoupling coupling_;
  DevicePose pose_;
  DeviceWrench wrench_;
};

/// How a device does, for those beside its thread.
struct DeviceStatus {
  bool connected = true;
  std::int64_t poses = 0, refused = 0;  // that came; messages that were none
  double lacking = 0;                   // as DeviceReport's
};

/// A device on a thread of its own, at 1 kHz or the loop's rate, whichever is higher. Between it and the loop there are
/// two wait-free channels: the loop's newest force and tool (ForceOutput), and the tool's target (DeviceTargetSlot).
/// The thread asks for SCHED_FIFO as the loop does, and goes on without.
class DeviceThread {
 public:
  /// All but the backend must outlive this.
  DeviceThread(std::unique_ptr<DeviceBackend> backend, CoupledTool& tool, const Model& model,
               const SimulationLoop& loop);
  ~DeviceThread() { stop(); }
  DeviceThread(const DeviceThread&) = delete;
  DeviceThread& operator=(const DeviceThread&) = delete;

  /// With the loop: where the handle is then is the tool's start.
  void start() {
    thread_ = std::thread([this] { run(); });
  }

  /// Sends a last force of zero and joins.
  void stop();

  /// After stop().
  DeviceReport report() const { return link_.report(); }
  std::int64_t refusedCount() const { return backend_->refusedCount(); }
  std::int64_t exchanges() const { return exchanges_.load(std::memory_order_relaxed); }  // any time
  DeviceStatus status() const;                                                           // any time
  std::string name() const { return backend_->name(); }

 private:
  void run();

  std::unique_ptr<DeviceBackend> backend_;
  DeviceLink link_;
  const SimulationLoop& loop_;
  const std::int64_t period_ns_;
  std::atomic<bool> quit_{false}, connected_{true};
  std::atomic<std::int64_t> exchanges_{0}, poses_{0}, refused_{0};
  std::atomic<double> lacking_{0};
  std::thread thread_;
};

}  // namespace palpate

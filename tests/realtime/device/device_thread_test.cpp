#include "realtime/device/device_thread.h"

#include <atomic>
#include <catch2/catch.hpp>

#include "realtime/fakes.h"

using namespace palpate;

namespace {

/// A handle that goes down, and what was done to it.
struct Handle {
  std::atomic<int> writes{0};
  DeviceWrench last;  // after the thread's end
};

class FakeDevice final : public DeviceBackend {
 public:
  explicit FakeDevice(Handle& handle) : handle_(handle) {}
  std::string name() const override { return "fake"; }
  bool read(std::int64_t, DevicePose& pose) override {
    pose.sequence = ++sequence_;
    pose.pose.position = Vec3(0, 0, -1e-5 * std::min(sequence_, 500U));
    return true;
  }
  void write(std::int64_t, const DeviceWrench& wrench) override {
    handle_.last = wrench;
    handle_.writes.fetch_add(1, std::memory_order_relaxed);
  }

 private:
  Handle& handle_;
  std::uint32_t sequence_ = 0;
};

}  // namespace

TEST_CASE("Device and loop run beside each other, and the last force is none", "[device][timed]") {
  const Model model = test::smallModel(500);
  test::FakePhysics physics(model);
  CoupledTool tool(model);
  SimulationLoopOptions options;
  options.device = &tool;
  SimulationLoop loop(model, physics, nullptr, options);
  Handle handle;
  DeviceThread device(std::make_unique<FakeDevice>(handle), tool, model, loop);
  loop.start();
  device.start();
  // No deadline: a slow machine takes as long as it takes.
  while (loop.force().sample.pose_sequence == 0 || device.exchanges() < 20)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  device.stop();
  loop.quit();
  loop.join();
  CHECK(device.name() == "fake");
  CHECK(handle.last.force == Vec3::Zero());
  CHECK(handle.writes.load() == device.exchanges() + 1);
  CHECK(device.report().poses == device.exchanges());
}

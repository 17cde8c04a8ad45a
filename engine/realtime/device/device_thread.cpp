#include "realtime/device/device_thread.h"

#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <cmath>

#include "realtime/loop/thread_setup.h"
#include "realtime/timing/fixed_step_loop.h"

namespace palpate {
namespace {

/// Above the loop's threads, whose core it may share: it is done in microseconds, and they are not.
void askForRealTime() {
  flushDenormals();
  sched_param priority{};
  priority.sched_priority = 41;
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);  // refused: it goes on as an ordinary thread
  prctl(PR_SET_TIMERSLACK, 1UL);
}

}  // namespace

void DeviceLink::exchange(std::int64_t now, const ForceSample& tool) {
  const bool news = backend_.read(now, pose_);
  wrench_ = coupling_.update(now, news ? &pose_ : nullptr, tool, tool_.putBacks());
  backend_.write(now, wrench_);
  DeviceTarget& target = tool_.targets().back();
  target = coupling_.target();
  target.closes = (pose_.buttons & 1) != 0;
  tool_.targets().publish();
}

DeviceThread::DeviceThread(std::unique_ptr<DeviceBackend> backend, CoupledTool& tool, const Model& model,
                           const SimulationLoop& loop)
    : backend_(std::move(backend)),
      link_(*backend_, tool, model),
      loop_(loop),
      period_ns_(std::llround(1e9 / std::max(1000.0, model.scene.dynamics.rate_hz))) {}

DeviceStatus DeviceThread::status() const {
  constexpr auto any = std::memory_order_relaxed;
  return {connected_.load(any), poses_.load(any), refused_.load(any), lacking_.load(any)};
}

void DeviceThread::stop() {
  quit_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

void DeviceThread::run() {
  askForRealTime();
  MonotonicClock clock;
  std::int64_t next = clock.now();
  while (!quit_.load(std::memory_order_relaxed)) {
    link_.exchange(clock.now(), loop_.force().sample);
    exchanges_.fetch_add(1, std::memory_order_relaxed);
    connected_.store(backend_->connected(), std::memory_order_relaxed);
    poses_.store(link_.coupling().poses(), std::memory_order_relaxed);
    refused_.store(backend_->refusedCount(), std::memory_order_relaxed);
    lacking_.store(link_.coupling().lacking(), std::memory_order_relaxed);
    const std::int64_t now = clock.now();
    next += period_ns_ * std::max<std::int64_t>(1, (now - next) / period_ns_ + 1);  // what was missed is skipped
    clock.sleepUntil(next);
  }
  DeviceWrench rest = link_.wrench();
  ++rest.sequence;
  rest.force.setZero();
  rest.torque.setZero();
  backend_->write(clock.now(), rest);
}

}  // namespace palpate

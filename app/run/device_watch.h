#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "realtime/device/device_thread.h"

namespace palpate::app {

/// Tells of a device while it runs: whether poses come, and often enough, and whether the hand feels all that it
/// should.
/// Test: app/run/device_watch_test.cpp
class DeviceWatch {
 public:
  using Tell = std::function<void(bool warning, const std::string& text)>;

  /// @param name  of the device
  DeviceWatch(std::string name, Tell tell) : name_(std::move(name)), tell_(std::move(tell)) {}

  /// @param seconds  by a clock that goes on
  void update(const DeviceStatus& status, double seconds);

  int losses() const { return losses_; }

 private:
  void watchPoses(const DeviceStatus& status, double seconds);
  void watchRate(const DeviceStatus& status, double seconds);
  void watchForce(const DeviceStatus& status, double seconds);

  std::string name_;
  Tell tell_;
  bool there_ = true;
  int losses_ = 0;
  double begin_ = -1, first_pose_ = -1, last_pose_ = -1;  // s; < 0: not yet
  std::int64_t poses_ = 0, counted_from_ = 0;
  bool silence_told_ = false, refused_told_ = false, rate_told_ = false;
  double lacking_since_ = -1, lacking_last_ = -1;
  bool lacking_told_ = false;
};

}  // namespace palpate::app

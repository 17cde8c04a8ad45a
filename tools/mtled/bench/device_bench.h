#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "mtled/bench/device_rig.h"

namespace palpate::tools {

/// What is promised of every device, hand, delay and body.
struct DeviceBounds {
  static constexpr double limit_cycle = 0.01;  // of the peak force, above 20 Hz
  static constexpr double energy_J = -1e-3;    // observed
  static constexpr double static_error = 0.02;
  static constexpr double silence_ms = 60;  // from the last pose to no force
  static constexpr double latency_ticks = 2;
};

struct DeviceRow {
  std::string body;
  DeviceTrial trial;
  DeviceResult result;
};

/// Which bounds a row misses, as words; empty: none.
std::string missedBounds(const DeviceResult& result);

struct DeviceBenchOptions {
  bool quick = false;  // a device, a hand and the ends of the delays on each body
  std::string json;    // file, or ""
  bool check = false;
};

/// Runs simulated devices in simulated hands over liver, gel and inclusion in simulated time, and prints what was held.
/// @return 0; 1 where a bound was missed and `check` says that this is a failure, or it was interrupted
int deviceBench(const DeviceBenchOptions& options);

void printDeviceRows(std::ostream& out, const std::vector<DeviceRow>& rows);

}  // namespace palpate::tools

#pragma once

#include <cstdint>
#include <string>

#include "realtime/device/device_signals.h"

namespace palpate {

/// A way to a haptic device. All but the constructor is called by one thread, about a thousand times a second: neither
/// function waits while there is a device.
class DeviceBackend {
 public:
  virtual ~DeviceBackend() = default;

  /// "udp on 127.0.0.1:7711", for people.
  virtual std::string name() const = 0;

  /// The newest pose that has come since the last call; false: none has.
  /// @param now_ns  by the clock of the device's thread
  virtual bool read(std::int64_t now_ns, DevicePose& pose) = 0;

  /// Hands the device its force, which holds until the next. What can't be sent is dropped: the next is newer.
  virtual void write(std::int64_t now_ns, const DeviceWrench& wrench) = 0;

  /// False where what the device hangs on is known to be gone; read() then looks whether it is back.
  virtual bool connected() const { return true; }

  /// Messages that came and could not be used.
  virtual std::int64_t refusedCount() const { return 0; }
};

}  // namespace palpate

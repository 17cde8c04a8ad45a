#pragma once

#include <cstdint>

#include "base/types.h"
#include "realtime/channels/triple_buffer.h"

namespace palpate {

/// Where a device pulls the tool, and how hard: the loop's end of the coupling. In the scene's frame.
struct DeviceTarget {
  bool engaged = false;  // else the tool stays where it is
  bool closes = false;   // jaws: they close while this is so, else they open as far as they were
  Pose pose;
  Vec3 velocity = Vec3::Zero();  // m/s
  double stiffness = 0;          // N/m
  double damping = 0;            // N s/m
  Vec3 turning = Vec3::Zero();   // rad/s
  double turning_stiffness = 0;  // N m/rad; 0: the tool's orientation is the target's
  double turning_damping = 0;    // N m s/rad
  std::uint64_t sequence = 0;    // DevicePose::sequence
};

/// The newest target, from the device's thread to the loop's: the latest wins, and nothing smooths it.
///   device's thread:  back(), publish()
///   loop's thread:    latest()
using DeviceTargetSlot = TripleBuffer<DeviceTarget>;

}  // namespace palpate

#pragma once

#include <cstdint>

#include "base/types.h"

namespace palpate {

/// What a haptic device tells of its handle. SI units, in the device's frame: z up, right-handed.
struct DevicePose {
  std::uint32_t sequence = 0;  // counts up from 1; the highest wins
  std::uint32_t felt = 0;      // sequence of the newest wrench that the device has applied; 0: it does not say
  std::uint32_t buttons = 0;   // a bit each; the lowest closes jaws
  std::int64_t sent_ns = 0;    // by the device's clock, whatever its zero
  Pose pose;                   // of the handle
  Vec3 velocity = Vec3::Zero();
  bool has_velocity = false;  // else it is made from poses
};

/// What a device is to push its handle with.
struct DeviceWrench {
  std::uint32_t sequence = 0;  // counts up from 1
  std::uint32_t answers = 0;   // DevicePose::sequence
  std::int64_t sent_ns = 0;    // by our clock
  Vec3 force = Vec3::Zero();   // N, on the handle
  Vec3 torque = Vec3::Zero();  // N m, on the handle
  bool touching = false;
  bool doubted = false;         // the tissue's force is not to be trusted (ForceSample::doubt)
  bool short_of_force = false;  // DeviceReport::lacking is above DeviceCoupling::felt_lacking
};

/// Whether the numbers can be those of a pose: finite, a turn that is one, within 10 m and 100 m/s.
bool isSane(const DevicePose& pose);

}  // namespace palpate

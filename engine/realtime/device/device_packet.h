#pragma once

#include <array>
#include <cstdint>

#include "realtime/device/device_signals.h"

namespace palpate {

/// The packets of the UDP bridge, 64 bytes each, little-endian, floats of 32 bits (engine/realtime/device/README.md).
using DevicePacket = std::array<unsigned char, 64>;

/// "PLP1": a pose; "PLF1": a force.
constexpr std::uint32_t pose_magic = 0x31504c50, force_magic = 0x31464c50;

DevicePacket packetOf(const DevicePose& pose);
DevicePacket packetOf(const DeviceWrench& wrench);

/// False where these are no such packet, or have numbers that can't be.
bool readPacket(const unsigned char* bytes, std::size_t count, DevicePose& pose);
bool readPacket(const unsigned char* bytes, std::size_t count, DeviceWrench& wrench);

}  // namespace palpate

#pragma once

#include <memory>
#include <string>

#include "model/model.h"
#include "realtime/device/device_backend.h"

namespace palpate {

/// What --device asks for: "simulated", "udp", "udp:7711" or "ws://localhost:10001". Throws InputError for another,
/// std::runtime_error where the port is taken: before a scene is made ready for it.
void checkDevice(const std::string& device);

/// The device that it names. The simulated one is of the scene's class, in a hand that presses, rests and slides.
/// Throws InputError as checkDevice, std::runtime_error where it can't be reached.
std::unique_ptr<DeviceBackend> openDevice(const std::string& device, const Model& model);

}  // namespace palpate

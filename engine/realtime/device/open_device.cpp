#include "realtime/device/open_device.h"

#include "base/input_error.h"
#include "realtime/device/simulated_device.h"
#include "realtime/device/udp_device.h"
#include "realtime/device/websocket_device.h"

namespace palpate {
namespace {

/// The port of "udp:7711"; -1: not one.
int udpPort(const std::string& device) {
  if (device == "udp") return UdpDevice::default_port;
  if (!device.starts_with("udp:")) return -1;
  const std::string port = device.substr(4);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos) return -1;
  return std::stoi(port) <= 65535 ? std::stoi(port) : -1;
}

/// The simulated device that pushes as much as the scene's coupling may.
int classOf(const DeviceSettings& settings) {
  int device_class = 0;
  for (int c = 0; c < static_cast<int>(DeviceSettings::classes.size()); ++c)
    if (settings.max_force >= DeviceSettings::of(c).max_force) device_class = c;
  return device_class;
}

}  // namespace

void checkDevice(const std::string& device) {
  if (device == "simulated") return;
  if (device.starts_with("ws://"))
    websocketAddress(device);
  else if (const int port = udpPort(device); port >= 0)
    UdpDevice{port};
  else
    throw InputError({}, inQuotes(device) + " is no device", "choose simulated, udp, udp:PORT or ws://localhost:PORT");
}

std::unique_ptr<DeviceBackend> openDevice(const std::string& device, const Model& model) {
  checkDevice(device);
  if (device.starts_with("ws://")) return std::make_unique<WebsocketDevice>(device);
  if (device != "simulated") return std::make_unique<UdpDevice>(udpPort(device));
  HandMotion motion;
  motion.kind = HandMotion::Kind::Wander;
  motion.down = model.tools.first().start.pose.orientation * -Vec3::UnitZ();
  motion.along = model.tools.first().start.pose.orientation * Vec3::UnitX();
  motion.depth = model.tools.first().first_contact_travel + 0.8 * model.scene.tools[0].shape.radius;
  motion.slide = 0.5 * model.scene.tools[0].shape.radius;
  const double scale = model.scene.device.scale;
  motion.depth /= scale, motion.slide /= scale;
  return std::make_unique<SimulatedDevice>(SimulatedDeviceSettings::of(classOf(model.scene.device)), HandModel::light(),
                                           motion);
}

}  // namespace palpate

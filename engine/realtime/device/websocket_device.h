#pragma once

#include <chrono>
#include <optional>

#include "realtime/device/device_backend.h"
#include "realtime/device/websocket_frames.h"

namespace palpate {

/// Where a service of this machine is.
struct WebsocketAddress {
  std::string text{}, host{}, path{};
  int port = 0;
};

/// Of "ws://127.0.0.1:10001/path". Throws InputError where it is none of this machine.
WebsocketAddress websocketAddress(const std::string& text);

/// A vendor's service on this machine that tells states and takes forces as JSON over a WebSocket, so that no SDK is
/// needed. The messages are those of Haply's Inverse Service, version 3.1, as its public examples have them:
///
///   service:  {"inverse3": [{"device_id": "049D", "state": {"cursor_position": {"x":, "y":, "z":},
///              "cursor_velocity": {...}}}],
///              "wireless_verse_grip": [{"state": {"orientation": {"w":, "x":, "y":, "z":}, "buttons": {"a": true}}}]}
///   we:       {"inverse3": [{"device_id": "049D", "commands": {"set_cursor_force": {"values": {"x":, "y":, "z":}}}}]}
///
/// The service answers each command with the next state. It was written from these messages and tested against a
/// server of our own in the tests; no device was ever connected.
/// A service that goes away is looked for each second, and may be another one when it is back.
/// read() and write() don't wait, but for one that is back, at most a fifth of a second; they parse and make text, and
/// so allocate: on the device's thread only.
class WebsocketDevice final : public DeviceBackend {
 public:
  /// Connects: at most two seconds. @param address  ws://127.0.0.1:10001 or ws://localhost:10001/path
  /// Throws InputError for an address that is none or not of this machine, std::runtime_error where nobody answers.
  explicit WebsocketDevice(const std::string& address);
  ~WebsocketDevice() override;
  WebsocketDevice(const WebsocketDevice&) = delete;
  WebsocketDevice& operator=(const WebsocketDevice&) = delete;

  std::string name() const override { return address_.text; }
  bool read(std::int64_t now_ns, DevicePose& pose) override;
  void write(std::int64_t now_ns, const DeviceWrench& wrench) override;
  std::int64_t refusedCount() const override { return refused_; }
  bool connected() const override { return socket_ >= 0; }

 private:
  void connect(std::int64_t patience_ms);
  void shakeHands(std::chrono::steady_clock::time_point deadline);
  void receive();
  bool takeState(const std::string& text, DevicePose& pose);
  void send(const WebsocketFrame& frame);
  void close();

  const WebsocketAddress address_;
  int socket_ = -1;
  std::int64_t next_try_ns_ = 0;  // where it is gone
  WebsocketReader reader_;
  std::string device_;  // its id; empty: none told yet
  std::string unsent_;
  DevicePose pose_;  // the newest
  std::uint32_t mask_ = 0x9e3779b9;
  std::int64_t refused_ = 0;
};

}  // namespace palpate

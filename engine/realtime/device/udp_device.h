#pragma once

#include "realtime/device/device_backend.h"

namespace palpate {

/// A bridge program on this machine that sends pose packets to a port of 127.0.0.1, and gets a force packet back for
/// each call of write() (device_packet.h). Its address is where the last good pose came from.
/// read() and write() are a system call or a few each, and don't wait.
class UdpDevice final : public DeviceBackend {
 public:
  static constexpr int default_port = 7711;

  /// @param port  0: one that is free
  /// Throws std::runtime_error where the port can't be had.
  explicit UdpDevice(int port = default_port);
  ~UdpDevice() override;
  UdpDevice(const UdpDevice&) = delete;
  UdpDevice& operator=(const UdpDevice&) = delete;

  int port() const { return port_; }
  std::string name() const override { return "udp on 127.0.0.1:" + std::to_string(port_); }
  bool read(std::int64_t now_ns, DevicePose& pose) override;
  void write(std::int64_t now_ns, const DeviceWrench& wrench) override;
  std::int64_t refusedCount() const override { return refused_; }

 private:
  int socket_ = -1, port_ = 0;
  int peer_port_ = 0;           // 0: nobody yet
  std::uint32_t newest_ = 0;    // sequence
  std::int64_t newest_ns_ = 0;  // when it came
  std::int64_t refused_ = 0;
};

}  // namespace palpate

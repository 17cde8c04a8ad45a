#include "realtime/device/udp_device.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "realtime/device/device_packet.h"

namespace palpate {
namespace {

// A bridge that has been silent for so long may have begun anew: it counts from 1 again.
constexpr std::int64_t kForgottenNs = 100'000'000;

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

UdpDevice::UdpDevice(int port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  sockaddr_in address = loopback(port);
  socklen_t size = sizeof address;
  if (socket_ < 0 || ::bind(socket_, reinterpret_cast<sockaddr*>(&address), size) != 0 ||
      ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    const std::string reason = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    throw std::runtime_error("can't listen on UDP port " + std::to_string(port) + " of 127.0.0.1: " + reason +
                             "; choose another one: --device udp:PORT");
  }
  port_ = ntohs(address.sin_port);
}

UdpDevice::~UdpDevice() { ::close(socket_); }

bool UdpDevice::read(std::int64_t now_ns, DevicePose& pose) {
  constexpr int kAtOnce = 64;  // a bridge that floods the port must not hold this thread
  bool news = false;
  for (int k = 0; k < kAtOnce; ++k) {
    unsigned char bytes[128];
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count = ::recvfrom(socket_, bytes, sizeof bytes, 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0) break;
    DevicePose next;
    if (!readPacket(bytes, static_cast<std::size_t>(count), next)) {
      ++refused_;
      continue;
    }
    const bool new_peer = ntohs(from.sin_port) != peer_port_;
    if (new_peer && peer_port_ != 0 && now_ns - newest_ns_ < kForgottenNs) {  // one device at a time
      ++refused_;
      continue;
    }
    const bool overtaken = !new_peer && static_cast<std::int32_t>(next.sequence - newest_) <= 0;
    if (overtaken && now_ns - newest_ns_ < kForgottenNs) {
      if (next.sequence == newest_) ++refused_;  // a bridge that does not count looks like this
      continue;
    }
    peer_port_ = ntohs(from.sin_port);
    newest_ = next.sequence;
    newest_ns_ = now_ns;
    pose = next;
    news = true;
  }
  return news;
}

void UdpDevice::write(std::int64_t, const DeviceWrench& wrench) {
  if (peer_port_ == 0) return;
  const DevicePacket packet = packetOf(wrench);
  const sockaddr_in to = loopback(peer_port_);
  [[maybe_unused]] const ssize_t sent =
      ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

}  // namespace palpate

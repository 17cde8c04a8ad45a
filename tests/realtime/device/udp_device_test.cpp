#include "realtime/device/udp_device.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <thread>

#include "base/input_error.h"
#include "realtime/device/device_packet.h"
#include "realtime/device/open_device.h"
#include "realtime/fakes.h"

using namespace palpate;
using Catch::Contains;

namespace {

/// A bridge as somebody else's program would be: a socket of its own.
struct Bridge {
  int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  explicit Bridge(int port) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(socket, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0);
  }
  ~Bridge() { ::close(socket); }
  void send(const void* bytes, std::size_t count) const {
    REQUIRE(::send(socket, bytes, count, 0) == static_cast<ssize_t>(count));
  }
  void send(const DevicePose& pose) const {
    const DevicePacket packet = packetOf(pose);
    send(packet.data(), packet.size());
  }
};

DevicePose samplePose(std::uint32_t sequence) {
  DevicePose pose;
  pose.sequence = sequence;
  pose.felt = 7;
  pose.buttons = 5;
  pose.sent_ns = -123456789012345;
  pose.pose.position = Vec3(0.5, -0.25, 0.125);
  pose.pose.orientation = Quat(0.5, 0.5, -0.5, 0.5);
  pose.velocity = Vec3(1, 2, -4);
  pose.has_velocity = true;
  return pose;
}

/// What arrives on the loopback is there at once, or soon.
bool receives(UdpDevice& device, DevicePose& pose, std::int64_t now = 1) {
  for (int k = 0; k < 2000; ++k) {
    if (device.read(now, pose)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace

TEST_CASE("A pose's packet has the documented bytes and is read back", "[device]") {
  const DevicePose pose = samplePose(0x01020304);
  const DevicePacket packet = packetOf(pose);
  const unsigned char begin[16] = {'P', 'L', 'P', '1', 4, 3, 2, 1, 7, 0, 0, 0, 5, 0, 0, 0};
  CHECK(std::memcmp(packet.data(), begin, sizeof begin) == 0);
  const float numbers[10] = {0.5F, -0.25F, 0.125F, 0.5F, -0.5F, 0.5F, 0.5F, 1, 2, -4};  // quaternion: x, y, z, w
  CHECK(std::memcmp(packet.data() + 24, numbers, sizeof numbers) == 0);  // as this little-endian machine has them
  DevicePose read;
  REQUIRE(readPacket(packet.data(), packet.size(), read));
  CHECK(read.sequence == pose.sequence);
  CHECK(read.felt == 7);
  CHECK(read.sent_ns == pose.sent_ns);
  CHECK(read.pose.position == pose.pose.position);
  CHECK(read.pose.orientation.coeffs() == pose.pose.orientation.coeffs());
  CHECK(read.velocity == pose.velocity);
  CHECK(read.has_velocity);

  DeviceWrench wrench, back;
  wrench.sequence = 9;
  wrench.answers = 4;
  wrench.force = Vec3(1.5, 0, -2);
  wrench.touching = wrench.short_of_force = true;
  const DevicePacket force = packetOf(wrench);
  REQUIRE(readPacket(force.data(), force.size(), back));
  CHECK(back.force == wrench.force);
  CHECK(back.answers == 4);
  CHECK(back.touching);
  CHECK(back.short_of_force);
  CHECK_FALSE(back.doubted);
  CHECK_FALSE(readPacket(force.data(), force.size(), read));
}

TEST_CASE("Packets that can't be poses are refused", "[device]") {
  DevicePose pose = samplePose(1), read;
  const DevicePacket good = packetOf(pose);
  CHECK_FALSE(readPacket(good.data(), 63, read));
  CHECK_FALSE(readPacket(packetOf(samplePose(0)).data(), 64, read));
  DevicePacket other = good;
  other[3] = '2';
  CHECK_FALSE(readPacket(other.data(), 64, read));
  pose.pose.position.x() = std::nan("");
  CHECK_FALSE(readPacket(packetOf(pose).data(), 64, read));
  pose.pose.position.x() = 11;
  CHECK_FALSE(readPacket(packetOf(pose).data(), 64, read));
  pose = samplePose(1);
  pose.pose.orientation.coeffs().setZero();
  CHECK_FALSE(readPacket(packetOf(pose).data(), 64, read));
  pose = samplePose(1);
  pose.has_velocity = false;  // no number: the velocity is not known
  REQUIRE(readPacket(packetOf(pose).data(), 64, read));
  CHECK_FALSE(read.has_velocity);
}

TEST_CASE("Over UDP the newest pose wins, and its sender gets the force", "[device][timed]") {
  UdpDevice device(0);
  REQUIRE(device.port() > 0);
  DevicePose pose;
  CHECK_FALSE(device.read(1, pose));
  device.write(1, {});  // nobody to send it to
  const Bridge bridge(device.port());
  bridge.send(samplePose(3));
  REQUIRE(receives(device, pose));
  CHECK(pose.sequence == 3);
  CHECK(pose.pose.position == samplePose(3).pose.position);

  bridge.send("no packet", 9);
  bridge.send(samplePose(2));  // overtaken
  bridge.send(samplePose(5));
  const Bridge second(device.port());
  second.send(samplePose(6));  // a second device
  bridge.send(samplePose(7));
  while (pose.sequence < 7) REQUIRE(receives(device, pose));
  CHECK(device.refusedCount() == 2);

  DeviceWrench wrench, got;
  wrench.sequence = 1;
  wrench.answers = pose.sequence;
  wrench.force = Vec3(0, 0, 2.5);
  device.write(1, wrench);
  unsigned char bytes[128];
  REQUIRE(::recv(bridge.socket, bytes, sizeof bytes, 0) == 64);
  REQUIRE(readPacket(bytes, 64, got));
  CHECK(got.force == wrench.force);
  CHECK(got.answers == 7);

  second.send(samplePose(1));  // the first has been silent for long: another may begin
  REQUIRE(receives(device, pose, 1'000'000'000));
  CHECK(pose.sequence == 1);
}

TEST_CASE("The example of a bridge sends poses, and tells which force its motors have", "[device][timed]") {
  UdpDevice device(0);
  const std::string port = std::to_string(device.port());
  const char* const arguments[] = {PALPATE_UDP_EXAMPLE, port.c_str(), "60000", nullptr};
  pid_t child = 0;
  REQUIRE(posix_spawn(&child, PALPATE_UDP_EXAMPLE, nullptr, nullptr, const_cast<char* const*>(arguments), nullptr) ==
          0);
  DeviceWrench wrench;
  wrench.force = Vec3(0, 0, 3);
  DevicePose pose;
  double highest = -1;
  for (int k = 0; k < 20000 && (pose.felt < 100 || highest < 0); ++k) {  // its spring pulls down, and we push harder
    if (device.read(k, pose)) highest = std::max(highest, pose.pose.position.z());
    ++wrench.sequence;
    device.write(k, wrench);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ::kill(child, SIGTERM);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(pose.felt >= 100);
  CHECK(highest > 0);
  CHECK(device.refusedCount() == 0);
}

TEST_CASE("What is no device is refused with what there is", "[device]") {
  for (const char* device : {"", "udp:", "udp:70000", "udp:1x", "phantom", "simulated2"}) {
    CAPTURE(device);
    CHECK_THROWS_WITH(checkDevice(device), Contains("is no device; choose simulated, udp, udp:PORT"));
  }
  CHECK_NOTHROW(checkDevice("udp:0"));
  const Model model = test::smallModel();
  CHECK_THROWS_AS(openDevice("ws://example.org:80", model), InputError);
  CHECK_THROWS_AS(openDevice("ws://localhost", model), InputError);
  const UdpDevice taken(0);
  CHECK_THROWS_WITH(openDevice("udp:" + std::to_string(taken.port()), model), Contains("choose another one"));
  CHECK_THROWS_WITH(checkDevice("udp:" + std::to_string(taken.port())), Contains("choose another one"));
  DevicePose pose;
  CHECK(openDevice("simulated", model)->read(1'000'000, pose));
}

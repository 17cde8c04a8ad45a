#include "realtime/device/websocket_device.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <thread>

using namespace palpate;
using Catch::Contains;

namespace {

/// A service on a thread of its own, for one client after another. It stops where the last one is gone, and goes away
/// from those before at their first command.
class FakeService {
 public:
  explicit FakeService(bool proper = true, int clients = 1)
      : proper_(proper), clients_(clients), listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(::listen(listener_, 1) == 0);
    REQUIRE(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    url = "ws://127.0.0.1:" + std::to_string(ntohs(address.sin_port));
    thread_ = std::thread([this] {
      for (; clients_ > 0; --clients_) serve();
    });
  }
  ~FakeService() {
    join();
    ::close(listener_);
  }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  std::string url;
  // After join().
  std::vector<std::string> commands;
  std::string pong, closing;  // closing: what the Close of a client that was left had

 private:
  static constexpr const char* state =
      R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":-0.02,"z":0.03},)"
      R"("cursor_velocity":{"x":0.1,"y":0,"z":-0.1}}}],"wireless_verse_grip":[{"device_id":"1",)"
      R"("state":{"orientation":{"w":0,"x":0,"y":0,"z":1},"buttons":{"a":true,"b":false,"c":true}}}]})";

  // The grip is off.
  static constexpr const char* answer =
      R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":-0.02,"z":0.04}}}],)"
      R"("wireless_verse_grip":[{"device_id":"1","state":{"orientation":{"w":0,"x":0,"y":0,"z":0},"buttons":null}}]})";

  static inline const std::string going_away{"\x03\xe9", 2};  // 1001

  void serve() {
    const int client = ::accept(listener_, nullptr, nullptr);
    bytes_.clear();
    while (bytes_.find("\r\n\r\n") == std::string::npos && receive(client)) {
    }
    const std::string header = "Sec-WebSocket-Key: ";
    const std::size_t key = bytes_.find(header) + header.size();
    const std::string accept = websocketAccept(bytes_.substr(key, bytes_.find("\r\n", key) - key));
    bytes_.clear();
    send(client,
         "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
         "sec-websocket-accept: " +
             (proper_ ? accept : std::string("nonsense")) + "\r\n\r\n");
    if (proper_) {
      send(client, websocketFrame({WebsocketFrame::Kind::Text, "{}"}, {}));
      send(client, websocketFrame({WebsocketFrame::Kind::Ping, "still there?"}, {}));
      // The state in two parts.
      const std::string text = state;
      std::string first = websocketFrame({WebsocketFrame::Kind::Text, text.substr(0, 100)}, {});
      first[0] = 0x01;
      std::string second = websocketFrame({WebsocketFrame::Kind::Text, text.substr(100)}, {});
      second[0] = static_cast<char>(0x80);
      send(client, first + second);
    }
    while (receive(client)) takeFrames(client);
    ::close(client);
  }
  bool receive(int client) {
    char some[512];
    const ssize_t count = ::recv(client, some, sizeof some, 0);
    if (count > 0) bytes_.append(some, static_cast<std::size_t>(count));
    return count > 0;
  }
  static void send(int client, const std::string& bytes) {
    [[maybe_unused]] const ssize_t sent = ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  /// A client's frames are masked; ours here are short or of two length bytes.
  void takeFrames(int client) {
    for (;;) {
      const auto at = [&](std::size_t k) { return static_cast<unsigned char>(bytes_[k]); };
      if (bytes_.size() < 8) return;
      const std::size_t extra = (at(1) & 0x7f) == 126 ? 2 : 0;
      const std::size_t size = extra == 2 ? at(2) * 256U + at(3) : at(1) & 0x7fU, head = 2 + extra + 4;
      if (bytes_.size() < head + size) return;
      std::string text = bytes_.substr(head, size);
      for (std::size_t k = 0; k < size; ++k) text[k] = static_cast<char>(text[k] ^ bytes_[2 + extra + k % 4]);
      const unsigned opcode = at(0) & 0x0fU;
      bytes_.erase(0, head + size);
      if (opcode == 0xa) pong = text;
      if (opcode == 0x8 && clients_ > 1) closing = text;
      if (opcode == 0x1 && clients_ > 1) {
        send(client, websocketFrame({WebsocketFrame::Kind::Close, going_away}, {}));
      } else if (opcode == 0x1) {
        commands.push_back(text);
        send(client, websocketFrame({WebsocketFrame::Kind::Text, answer}, {}));
      }
    }
  }

  bool proper_;
  int clients_, listener_;
  std::string bytes_;
  std::thread thread_;
};

bool receives(WebsocketDevice& device, DevicePose& pose) {
  for (int k = 0; k < 5000; ++k) {
    if (device.read(1, pose)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace

TEST_CASE("The answer to a client's key is that of RFC 6455", "[device]") {
  CHECK(websocketAccept("dGhlIHNhbXBsZSBub25jZQ==") == "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");  // its section 1.3
}

TEST_CASE("Frames are those of RFC 6455, and are read byte by byte", "[device]") {
  // Its section 5.7: "Hello", masked and not.
  const unsigned char masked[] = {0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58};
  const std::string hello = websocketFrame({WebsocketFrame::Kind::Text, "Hello"}, 0x37fa213dU);
  CHECK(hello == std::string(reinterpret_cast<const char*>(masked), sizeof masked));
  const std::string longer(70000, 'x');
  const std::string all = websocketFrame({WebsocketFrame::Kind::Text, "Hello"}, {}) +
                          websocketFrame({WebsocketFrame::Kind::Text, longer}, {}) +
                          websocketFrame({WebsocketFrame::Kind::Close, ""}, {});
  WebsocketReader reader;
  std::vector<WebsocketFrame> frames;
  for (const char c : all) {
    reader.add({&c, 1});
    while (auto frame = reader.next()) frames.push_back(*frame);
  }
  REQUIRE(frames.size() == 3);
  CHECK(frames[0].text == "Hello");
  CHECK(frames[1].text == longer);
  CHECK(frames[2].kind == WebsocketFrame::Kind::Close);
  WebsocketReader strict;
  strict.add(hello);  // no server masks
  CHECK_THROWS(strict.next());
}

TEST_CASE("A service's state becomes a pose, and the force its command", "[device]") {
  FakeService service;
  {
    WebsocketDevice device(service.url);
    device.write(1, {});  // no device is known yet: nothing to command
    DevicePose pose;
    REQUIRE(receives(device, pose));
    CHECK(pose.pose.position == Vec3(0.01, -0.02, 0.03));
    CHECK(pose.velocity == Vec3(0.1, 0, -0.1));
    CHECK(pose.pose.orientation.coeffs() == Quat(0, 0, 0, 1).coeffs());
    CHECK(pose.buttons == 5);
    CHECK(device.refusedCount() == 1);  // "{}" tells of no device
    const std::uint32_t first = pose.sequence;
    DeviceWrench wrench;
    wrench.force = Vec3(0.5, 0, -1.25);
    device.write(1, wrench);
    REQUIRE(receives(device, pose));  // the answer
    CHECK(pose.sequence == first + 1);
    CHECK(pose.pose.position.z() == 0.04);
    CHECK(pose.pose.orientation.coeffs() == Quat(0, 0, 0, 1).coeffs());  // as the hand held it
    CHECK(pose.buttons == 0);
    CHECK(device.refusedCount() == 1);
    CHECK(device.connected());
  }
  service.join();
  CHECK(service.pong == "still there?");
  REQUIRE(service.commands.size() == 1);
  const nlohmann::json command = nlohmann::json::parse(service.commands[0]);
  CHECK(command == nlohmann::json::parse(R"({"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":
        {"values":{"x":0.5,"y":0.0,"z":-1.25}}}}]})"));
}

TEST_CASE("A service that goes away is answered, known to be gone, and found when it is back", "[device]") {
  FakeService service(true, 2);
  {
    WebsocketDevice device(service.url);
    DevicePose pose;
    REQUIRE(receives(device, pose));
    const std::uint32_t first = pose.sequence;
    device.write(1, {});
    for (int k = 0; k < 5000 && device.connected(); ++k) {
      device.read(1, pose);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    REQUIRE_FALSE(device.connected());
    REQUIRE(receives(device, pose));  // at once: the first try is due
    CHECK(device.connected());
    CHECK(pose.sequence == first + 1);
    device.write(1, {});
    REQUIRE(receives(device, pose));
  }
  service.join();
  CHECK(service.closing == std::string("\x03\xe9", 2));
  CHECK(service.commands.size() == 1);
}

TEST_CASE("A service that answers letter by letter is waited for no longer than one that is silent", "[device]") {
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(listener, 1) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  int letters = 0;
  std::thread service([&] {
    const int client = ::accept(listener, nullptr, nullptr);
    for (; letters < 16384 && ::send(client, "H", 1, MSG_NOSIGNAL) == 1; ++letters)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ::close(client);
  });
  CHECK_THROWS_WITH(WebsocketDevice("ws://127.0.0.1:" + std::to_string(ntohs(address.sin_port))),
                    Contains("did not answer as a WebSocket does"));
  service.join();
  ::close(listener);
  CHECK(letters < 2000);  // of two seconds some 400; without an end of them all
}

TEST_CASE("What does not become a WebSocket is told", "[device]") {
  FakeService service(false);
  CHECK_THROWS_WITH(WebsocketDevice(service.url), Contains("did not become a WebSocket"));
  service.join();
}

#include "realtime/device/websocket_device.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "base/input_error.h"
#include "base/printable_text.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

/// Of a person who has just started both; of the device's thread, for the whole of a handshake: its end waits no
/// longer. No hand notices a try each second, and no service is burdened.
constexpr std::int64_t first_patience_ms = 2000, patience_ms = 200, try_again_ns = 1'000'000'000;

Vec3 vectorOf(const Json& json) {
  return {json.at("x").get<double>(), json.at("y").get<double>(), json.at("z").get<double>()};
}

/// How the grip is turned, and its buttons. What is no turn (a grip that is off tells zeros) leaves it as it was: the
/// hand holds on.
void takeGrip(const Json& state, DevicePose& pose) {
  if (state.contains("orientation") && state["orientation"].is_object()) {
    const Json& turn = state["orientation"];
    const auto part = [&](const char* name) {
      return turn.contains(name) && turn[name].is_number() ? turn[name].get<double>() : 0.0;
    };
    const Quat read(part("w"), part("x"), part("y"), part("z"));
    if (read.norm() > 0.5 && read.norm() < 2) pose.pose.orientation = read;
  }
  pose.buttons = 0;
  if (!state.contains("buttons") || !state["buttons"].is_object()) return;
  for (unsigned b = 0; b < 3; ++b) {
    const std::string name(1, static_cast<char>('a' + b));
    const Json& buttons = state["buttons"];
    if (buttons.contains(name) && (buttons[name] == true || buttons[name] == 1)) pose.buttons |= 1U << b;
  }
}

}  // namespace

WebsocketAddress websocketAddress(const std::string& text) {
  const auto wrong = [&] {
    return InputError({}, inQuotes(text) + " is no WebSocket of this machine", "write ws://127.0.0.1:PORT[/PATH]");
  };
  if (!text.starts_with("ws://")) throw wrong();
  const std::size_t slash = text.find('/', 5), colon = text.find(':', 5);
  WebsocketAddress address{.text = text};
  address.path = slash == std::string::npos ? "/" : text.substr(slash);
  if (colon == std::string::npos || colon > slash) throw wrong();
  address.host = text.substr(5, colon - 5);
  const std::string port = text.substr(colon + 1, slash == std::string::npos ? slash : slash - colon - 1);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos) throw wrong();
  address.port = std::stoi(port);
  // A force on a hand does not go through a network.
  if (address.port < 1 || address.port > 65535 || (address.host != "localhost" && address.host != "127.0.0.1"))
    throw wrong();
  if (std::any_of(address.path.begin(), address.path.end(), [](char c) { return c <= ' ' || c > '~'; })) throw wrong();
  return address;
}

WebsocketDevice::WebsocketDevice(const std::string& address) : address_(websocketAddress(address)) {
  connect(first_patience_ms);
}

/// Throws std::runtime_error where nobody answers.
void WebsocketDevice::connect(std::int64_t wait_ms) {
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in where{};
  where.sin_family = AF_INET;
  where.sin_port = htons(static_cast<std::uint16_t>(address_.port));
  where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval wait{wait_ms / 1000, 1000 * (wait_ms % 1000)};
  const int at_once = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &wait, sizeof wait);
  ::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once);
  if (socket_ < 0 || ::connect(socket_, reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0) {
    const std::string reason = std::strerror(errno);
    close();
    throw std::runtime_error("no service at " + address_.text + ": " + reason + "; start the device's service first");
  }
  reader_ = {};
  unsent_.clear();
  device_.clear();
  try {
    shakeHands(std::chrono::steady_clock::now() + std::chrono::milliseconds(wait_ms));
  } catch (...) {
    close();
    throw;
  }
}

WebsocketDevice::~WebsocketDevice() {
  if (connected()) send({WebsocketFrame::Kind::Close, ""});
  close();
}

void WebsocketDevice::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

void WebsocketDevice::shakeHands(std::chrono::steady_clock::time_point deadline) {
  const std::string key = "cGFscGF0ZS1kZXZpY2UtMQ==";  // 16 bytes; a client on the loopback has nothing to hide
  const std::string request = "GET " + address_.path + " HTTP/1.1\r\nHost: " + address_.host + ":" +
                              std::to_string(address_.port) +
                              "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: " +
                              key + "\r\n\r\n";
  const auto failed = [&](const std::string& why) { return std::runtime_error(address_.text + " " + why); };
  if (::send(socket_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    throw failed("took no request");
  std::string answer;
  std::size_t end = std::string::npos;
  while ((end = answer.find("\r\n\r\n")) == std::string::npos) {
    char bytes[512];
    const ssize_t count = ::recv(socket_, bytes, sizeof bytes, 0);
    if (count <= 0 || answer.size() > 16384 || std::chrono::steady_clock::now() > deadline)
      throw failed("did not answer as a WebSocket does");
    answer.append(bytes, static_cast<std::size_t>(count));
  }
  const std::string head = answer.substr(0, end + 2), small = lowerCase(head);
  const std::size_t accept = small.find("\r\nsec-websocket-accept:");
  if (!head.starts_with("HTTP/1.1 101") || accept == std::string::npos ||
      head.substr(accept, head.find("\r\n", accept + 2) - accept).find(websocketAccept(key)) == std::string::npos)
    throw failed("did not become a WebSocket: it said " + inQuotes(head.substr(0, head.find('\r'))));
  reader_.add(std::string_view(answer).substr(end + 4));
}

/// What is there, without a wait.
void WebsocketDevice::receive() {
  char bytes[8192];
  for (int k = 0; k < 16 && connected(); ++k) {
    const ssize_t count = ::recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
    if (count > 0)
      reader_.add({bytes, static_cast<std::size_t>(count)});
    else if (count == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR))
      close();  // the dead man does the rest
    if (count < static_cast<ssize_t>(sizeof bytes)) return;
  }
}

void WebsocketDevice::send(const WebsocketFrame& frame) {
  constexpr std::size_t kMostUnsent = 1 << 16;  // a service that takes nothing is gone
  mask_ = mask_ * 1664525 + 1013904223;
  unsent_ += websocketFrame(frame, mask_);
  const ssize_t count = ::send(socket_, unsent_.data(), unsent_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (count > 0) unsent_.erase(0, static_cast<std::size_t>(count));
  if (unsent_.size() > kMostUnsent) close();
}

bool WebsocketDevice::takeState(const std::string& text, DevicePose& pose) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  try {
    const auto first = [&](const char* kind) -> const Json* {
      return json.contains(kind) && json[kind].is_array() && !json[kind].empty() ? &json[kind][0] : nullptr;
    };
    const Json* device = first("inverse3");
    if (device == nullptr) return false;
    const Json& state = device->at("state");
    DevicePose next = pose_;
    next.pose.position = vectorOf(state.at("cursor_position"));
    next.has_velocity = state.contains("cursor_velocity") && !state["cursor_velocity"].is_null();
    if (next.has_velocity) next.velocity = vectorOf(state["cursor_velocity"]);
    for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
      const Json* grip = first(kind);
      if (grip == nullptr || !grip->contains("state")) continue;
      const Json& turned = grip->at("state");
      takeGrip(turned, next);
      break;
    }
    ++next.sequence;
    if (!isSane(next)) return false;
    next.pose.orientation.normalize();
    device_ = device->at("device_id").get<std::string>();
    pose = pose_ = next;
    return true;
  } catch (const Json::exception&) {
    return false;
  }
}

bool WebsocketDevice::read(std::int64_t now_ns, DevicePose& pose) {
  if (!connected()) {
    if (now_ns < next_try_ns_) return false;
    next_try_ns_ = now_ns + try_again_ns;
    try {
      connect(patience_ms);
    } catch (const std::runtime_error&) {  // not yet
      return false;
    }
  }
  receive();
  bool news = false;
  try {
    while (const std::optional<WebsocketFrame> frame = reader_.next()) {
      if (frame->kind == WebsocketFrame::Kind::Text) {
        if (takeState(frame->text, pose))
          news = true;
        else
          ++refused_;
      } else if (frame->kind == WebsocketFrame::Kind::Ping && connected()) {
        send({WebsocketFrame::Kind::Pong, frame->text});
      } else if (frame->kind == WebsocketFrame::Kind::Close && connected()) {
        send({WebsocketFrame::Kind::Close, frame->text.substr(0, 2)});  // with the code that came
        close();
      }
    }
  } catch (const std::runtime_error&) {  // no server of this protocol
    ++refused_;
    close();
  }
  return news;
}

void WebsocketDevice::write(std::int64_t, const DeviceWrench& wrench) {
  if (!connected() || device_.empty()) return;
  const Vec3& f = wrench.force;
  const Json command{
      {"inverse3",
       {{{"device_id", device_},
         {"commands", {{"set_cursor_force", {{"values", {{"x", f.x()}, {"y", f.y()}, {"z", f.z()}}}}}}}}}}};
  send({WebsocketFrame::Kind::Text, command.dump(-1, ' ', true, Json::error_handler_t::replace)});
}

}  // namespace palpate

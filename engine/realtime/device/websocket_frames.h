#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

// What of RFC 6455 (The WebSocket Protocol) a client on this machine needs: no extensions, no encryption.

/// The answer that a server must give to a client's key: base64(SHA-1(key + GUID)), section 4.2.2.
std::string websocketAccept(const std::string& key);

struct WebsocketFrame {
  enum class Kind : std::uint8_t { Text, Close, Ping, Pong };
  Kind kind = Kind::Text;
  std::string text;
};

/// A whole frame. @param mask  of a client, any number; empty: a server's, which has none
std::string websocketFrame(const WebsocketFrame& frame, std::optional<std::uint32_t> mask);

/// Makes messages of the bytes that arrive; a message in parts becomes one, with control frames in between.
class WebsocketReader {
 public:
  static constexpr std::size_t longest = 1 << 20;  // bytes of a message

  void add(std::string_view bytes) { bytes_.append(bytes); }
  /// The next whole message or control frame. Throws std::runtime_error for what no server may send.
  std::optional<WebsocketFrame> next();

 private:
  std::string bytes_, parts_;
  bool in_parts_ = false;
};

}  // namespace palpate

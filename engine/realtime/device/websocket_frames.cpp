#include "realtime/device/websocket_frames.h"

#include <array>
#include <bit>
#include <stdexcept>

namespace palpate {
namespace {

/// FIPS 180-4, section 6.1.
std::array<std::uint8_t, 20> sha1(std::string bytes) {
  const std::uint64_t bits = 8 * static_cast<std::uint64_t>(bytes.size());
  bytes += '\x80';
  while (bytes.size() % 64 != 56) bytes += '\0';
  for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift);
  std::array<std::uint32_t, 5> H{0x67452301, 0xefcdab89, 0x98badcfe, 0x10325476, 0xc3d2e1f0};
  for (std::size_t block = 0; block < bytes.size(); block += 64) {
    std::array<std::uint32_t, 80> W{};
    for (std::size_t t = 0; t < 64; ++t) W[t / 4] = W[t / 4] << 8 | static_cast<std::uint8_t>(bytes[block + t]);
    for (std::size_t t = 16; t < 80; ++t) W[t] = std::rotl(W[t - 3] ^ W[t - 8] ^ W[t - 14] ^ W[t - 16], 1);
    auto [a, b, c, d, e] = H;
    for (std::size_t t = 0; t < 80; ++t) {
      const std::uint32_t f = t < 20   ? (b & c) ^ (~b & d)
                              : t < 40 ? b ^ c ^ d
                              : t < 60 ? (b & c) ^ (b & d) ^ (c & d)
                                       : b ^ c ^ d;
      constexpr std::array<std::uint32_t, 4> K{0x5a827999, 0x6ed9eba1, 0x8f1bbcdc, 0xca62c1d6};
      const std::uint32_t next = std::rotl(a, 5) + f + e + K[t / 20] + W[t];
      e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
    }
    H[0] += a, H[1] += b, H[2] += c, H[3] += d, H[4] += e;
  }
  std::array<std::uint8_t, 20> digest{};
  for (std::size_t k = 0; k < 20; ++k) digest[k] = static_cast<std::uint8_t>(H[k / 4] >> (24 - 8 * (k % 4)));
  return digest;
}

}  // namespace

std::string websocketAccept(const std::string& key) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto digest = sha1(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11");
  std::string text;
  for (std::size_t k = 0; k < digest.size(); k += 3) {
    std::uint32_t three = 0;
    for (std::size_t b = 0; b < 3; ++b) three = three << 8 | (k + b < digest.size() ? digest[k + b] : 0U);
    for (int d = 3; d >= 0; --d) text += digits[three >> (6 * d) & 63];
  }
  text.back() = '=';  // 20 bytes leave two of the last three
  return text;
}

std::string websocketFrame(const WebsocketFrame& frame, std::optional<std::uint32_t> mask) {
  constexpr std::array<unsigned char, 4> opcodes{0x1, 0x8, 0x9, 0xa};
  std::string out;
  const auto byte = [&](std::uint64_t value) { out += static_cast<char>(value & 0xff); };
  byte(0x80U | opcodes[static_cast<std::size_t>(frame.kind)]);
  const std::uint64_t size = frame.text.size(), masked = mask ? 0x80 : 0;
  if (size < 126) {
    byte(masked | size);
  } else {
    const int bytes = size < 65536 ? 2 : 8;
    byte(masked | (bytes == 2 ? 126U : 127U));
    for (int b = bytes - 1; b >= 0; --b) byte(size >> (8 * b));
  }
  if (!mask) return out + frame.text;
  for (int b = 3; b >= 0; --b) byte(*mask >> (8 * b));
  for (std::size_t k = 0; k < frame.text.size(); ++k)
    byte(static_cast<std::uint8_t>(frame.text[k]) ^ (*mask >> (8 * (3 - k % 4)) & 0xff));
  return out;
}

std::optional<WebsocketFrame> WebsocketReader::next() {
  for (;;) {
    const auto at = [&](std::size_t k) { return static_cast<std::uint8_t>(bytes_[k]); };
    if (bytes_.size() < 2) return {};
    const unsigned opcode = at(0) & 0x0fU, control = opcode & 8U;
    if ((at(0) & 0x70U) != 0 || (at(1) & 0x80U) != 0) throw std::runtime_error("a frame that no server may send");
    std::uint64_t size = at(1);
    const std::size_t length_bytes = size == 126 ? 2 : size == 127 ? 8 : 0, head = 2 + length_bytes;
    if (bytes_.size() < head) return {};
    if (length_bytes > 0) size = 0;
    for (std::size_t b = 0; b < length_bytes; ++b) size = size << 8 | at(2 + b);
    if (size > longest || parts_.size() + size > longest) throw std::runtime_error("a message of more than a megabyte");
    if (bytes_.size() < head + size) return {};
    const std::string text = bytes_.substr(head, static_cast<std::size_t>(size));
    const bool last = (at(0) & 0x80U) != 0;
    bytes_.erase(0, head + static_cast<std::size_t>(size));
    using Kind = WebsocketFrame::Kind;
    if (control != 0) {
      if (opcode > 0xa || !last) throw std::runtime_error("a control frame of no known kind");
      return WebsocketFrame{opcode == 8 ? Kind::Close : opcode == 9 ? Kind::Ping : Kind::Pong, text};
    }
    if (opcode > 2 || (opcode == 0) != in_parts_) throw std::runtime_error("a frame out of turn");
    parts_ += text;
    in_parts_ = !last;
    if (!last) continue;
    WebsocketFrame whole{Kind::Text, std::move(parts_)};
    parts_.clear();
    return whole;
  }
}

}  // namespace palpate

#include "io/base64.h"

#include <algorithm>
#include <cstddef>

namespace palpate {

void appendBase64(std::string& text, std::span<const unsigned char> bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = bytes[i] * 0x10000U;
    if (count > 1) group += bytes[i + 1] * 0x100U;
    if (count > 2) group += bytes[i + 2];
    text += digits[group >> 18];
    text += digits[group >> 12 & 63];
    text += count > 1 ? digits[group >> 6 & 63] : '=';
    text += count > 2 ? digits[group & 63] : '=';
  }
}

}  // namespace palpate

#pragma once

#include <span>
#include <string>

namespace palpate {

/// Appends bytes in the letters of RFC 4648, padded.
void appendBase64(std::string& text, std::span<const unsigned char> bytes);

}  // namespace palpate

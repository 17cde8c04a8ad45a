#pragma once

#include <cstdint>
#include <cstring>

#include "base/types.h"

namespace palpate {

/// A hash of a place's bits, m, mixed into that of those before it.
inline std::uint64_t hashOf(const Vec3& x, std::uint64_t hash = 0) {
  for (int c = 0; c < 3; ++c) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &x[c], sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace palpate

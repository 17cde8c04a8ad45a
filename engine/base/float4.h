#pragma once

#include <cstring>

#include "base/types.h"

namespace palpate {

/// Four floats in one register; what a Float4 is computed with.
using Group = float __attribute__((vector_size(16)));

inline Group loadGroup(const float* a) {  // a is 16-byte aligned
  Group g;
  std::memcpy(&g, __builtin_assume_aligned(a, 16), 16);
  return g;
}
inline void storeGroup(float* a, Group g) { std::memcpy(__builtin_assume_aligned(a, 16), &g, 16); }

inline Group load(const Float4& a) {
  Group g;
  std::memcpy(&g, &a, 16);
  return g;
}
inline void store(Float4& a, Group g) { std::memcpy(static_cast<void*>(&a), &g, 16); }

/// y += a x
inline void addScaled(Float4& y, float a, const Float4& x) { store(y, load(y) + a * load(x)); }

/// y *= a
inline void scale(Float4& y, float a) { store(y, a * load(y)); }

}  // namespace palpate

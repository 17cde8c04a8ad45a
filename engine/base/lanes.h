#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

namespace palpate {

// The widest vector of the target; a Lanes value is 16 floats made of as many of them as needed.
#if defined(__AVX512F__)
inline constexpr int native_lanes = 16;
#elif defined(__AVX__)
inline constexpr int native_lanes = 8;
#else
inline constexpr int native_lanes = 4;
#endif

/// Sixteen floats computed together: one AVX-512 register, two of AVX2 or four of SSE, from one
/// source. Seen as four groups of four where a function says "in each group".
struct Lanes {
  static constexpr int parts = 16 / native_lanes;
  using Vector = float __attribute__((vector_size(native_lanes * 4)));
  using Integer = std::int32_t __attribute__((vector_size(native_lanes * 4)));
  Vector v[parts];

  Lanes() = default;
  Lanes(float a) {  // NOLINT: a number is a vector of equal lanes
    for (auto& p : v) p = a - Vector{};
  }

  static Lanes load(const float* a) {  // a is 64-byte aligned
    Lanes r;
    std::memcpy(r.v, __builtin_assume_aligned(a, 64), sizeof r.v);
    return r;
  }
  void store(float* a) const { std::memcpy(__builtin_assume_aligned(a, 64), v, sizeof v); }

  /// Four unaligned groups of four.
  static Lanes gather(const float* g0, const float* g1, const float* g2, const float* g3) {
    Lanes r;
    const float* g[4] = {g0, g1, g2, g3};
    auto* to = reinterpret_cast<char*>(r.v);
    for (int k = 0; k < 4; ++k) std::memcpy(to + 16 * k, g[k], 16);
    return r;
  }
};

#define PALPATE_LANES_OP(op)                                              \
  inline Lanes operator op(const Lanes& a, const Lanes& b) {              \
    Lanes r;                                                              \
    for (int i = 0; i < Lanes::parts; ++i) r.v[i] = a.v[i] op b.v[i];     \
    return r;                                                             \
  }
PALPATE_LANES_OP(+)
PALPATE_LANES_OP(-)
PALPATE_LANES_OP(*)
PALPATE_LANES_OP(/)
#undef PALPATE_LANES_OP

inline Lanes& operator+=(Lanes& a, const Lanes& b) { return a = a + b; }
inline Lanes& operator-=(Lanes& a, const Lanes& b) { return a = a - b; }

inline Lanes max(const Lanes& a, const Lanes& b) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i) r.v[i] = a.v[i] > b.v[i] ? a.v[i] : b.v[i];
  return r;
}
/// a where x < y, else b.
inline Lanes whereLess(const Lanes& x, const Lanes& y, const Lanes& a, const Lanes& b) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i) r.v[i] = x.v[i] < y.v[i] ? a.v[i] : b.v[i];
  return r;
}
inline Lanes sqrt(const Lanes& a) {
  alignas(64) float s[16];
  a.store(s);
  for (float& x : s) x = std::sqrt(x);
  return Lanes::load(s);
}

namespace detail {
template <int K, std::size_t... I>
Lanes::Vector spread(const Lanes::Vector& a, std::index_sequence<I...>) {
  return __builtin_shuffle(a, Lanes::Integer{static_cast<int>(I / 4 * 4 + K)...});
}
// In each group of four lanes of a and b: (a0 b0 a1 b1), (a2 b2 a3 b3), (a0 a1 b0 b1), (a2 a3 b2 b3).
// Shuffle indices from native_lanes on name lanes of b.
template <std::size_t... I>
Lanes::Vector interleaveLow(const Lanes::Vector& a, const Lanes::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, Lanes::Integer{static_cast<int>(I / 4 * 4 + I % 4 / 2 + I % 2 * native_lanes)...});
}
template <std::size_t... I>
Lanes::Vector interleaveHigh(const Lanes::Vector& a, const Lanes::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, Lanes::Integer{static_cast<int>(I / 4 * 4 + I % 4 / 2 + 2 + I % 2 * native_lanes)...});
}
template <std::size_t... I>
Lanes::Vector joinLow(const Lanes::Vector& a, const Lanes::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, Lanes::Integer{static_cast<int>(I / 4 * 4 + I % 2 + I % 4 / 2 * native_lanes)...});
}
template <std::size_t... I>
Lanes::Vector joinHigh(const Lanes::Vector& a, const Lanes::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, Lanes::Integer{static_cast<int>(I / 4 * 4 + I % 2 + 2 + I % 4 / 2 * native_lanes)...});
}
}  // namespace detail

/// Lane K of each group, in all four lanes of that group.
template <int K>
Lanes spread(const Lanes& a) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i)
    r.v[i] = detail::spread<K>(a.v[i], std::make_index_sequence<native_lanes>{});
  return r;
}

/// Sums each group of a, b and c: group n of the result is (sum a_n, sum b_n, sum c_n, 0).
inline Lanes groupSums(const Lanes& a, const Lanes& b, const Lanes& c) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i) {
    using Vector = Lanes::Vector;
    constexpr auto all = std::make_index_sequence<native_lanes>{};
    const Vector ab = detail::interleaveLow(a.v[i], b.v[i], all) + detail::interleaveHigh(a.v[i], b.v[i], all);
    const Vector c0 = detail::interleaveLow(c.v[i], Vector{}, all) + detail::interleaveHigh(c.v[i], Vector{}, all);
    r.v[i] = detail::joinLow(ab, c0, all) + detail::joinHigh(ab, c0, all);
  }
  return r;
}

/// x^(-1/3) for x > 0: a guess from the exponent bits (3 % off) and three Newton steps to
/// float accuracy.
inline Lanes inverseCubeRoot(const Lanes& x) {
  Lanes y;
  for (int i = 0; i < Lanes::parts; ++i) {
    const auto bits = std::bit_cast<Lanes::Integer>(x.v[i]);
    const auto third = __builtin_convertvector(__builtin_convertvector(bits, Lanes::Vector) * (1.0F / 3), Lanes::Integer);
    y.v[i] = std::bit_cast<Lanes::Vector>(0x54a2fa8c - third);
  }
  for (int k = 0; k < 3; ++k) y = y * (Lanes(4.0F / 3) - Lanes(1.0F / 3) * x * y * y * y);
  return y;
}

/// Base-2 logarithm of x > 0 (normal numbers), error below 2e-7 absolute plus 1e-7 relative.
inline Lanes log2(const Lanes& x) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i) {
    using Vector = Lanes::Vector;
    const auto bits = std::bit_cast<Lanes::Integer>(x.v[i]);
    // Exponent chosen so that the mantissa lies in [1/sqrt 2, sqrt 2).
    const Lanes::Integer exponent = (bits - 0x3f3504f3) >> 23;
    const Vector m = std::bit_cast<Vector>(bits - (exponent << 23));
    const Vector t = (m - 1.0F) / (m + 1.0F);
    const Vector t2 = t * t;
    // log2 m = 2 / ln 2 * (t + t^3/3 + t^5/5 + ...), |t| < 0.172
    const Vector series = t * (2.885390082F + t2 * (0.961796694F + t2 * (0.577078016F + t2 * (0.412198583F + t2 * 0.320598898F))));
    r.v[i] = __builtin_convertvector(exponent, Vector) + series;
  }
  return r;
}

/// 2^x for |x| < 126, error below 2e-7 relative.
inline Lanes exp2(const Lanes& x) {
  Lanes r;
  for (int i = 0; i < Lanes::parts; ++i) {
    using Vector = Lanes::Vector;
    const Vector limited = x.v[i] < -126.0F ? Vector{} - 126.0F : (x.v[i] > 126.0F ? Vector{} + 126.0F : x.v[i]);
    // Rounds to the nearest integer: adding 1.5 * 2^23 pushes the fraction out of the mantissa.
    const Vector shifted = limited + 12582912.0F;
    const Lanes::Integer whole = std::bit_cast<Lanes::Integer>(shifted) - 0x4b400000;
    const Vector f = (limited - (shifted - 12582912.0F)) * 0.69314718F;
    const Vector p = 1.0F + f * (1.0F + f * (0.5F + f * (0.16666667F + f * (0.041666668F + f * (0.0083333338F + f * 0.0013888889F)))));
    r.v[i] = p * std::bit_cast<Vector>((whole + 127) << 23);
  }
  return r;
}

}  // namespace palpate

#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "base/kernel_namespace.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

// Nothing here calls an inline function of another library: see kernel_namespace.h. Intrinsics are none: the compiler
// never emits them as functions.
namespace palpate {
inline namespace PALPATE_KERNEL {

// The widest vector of the target, in bytes.
#if defined(__AVX512F__)
inline constexpr int native_bytes = 64;
#elif defined(__AVX__)
inline constexpr int native_bytes = 32;
#else
inline constexpr int native_bytes = 16;
#endif

/// Numbers computed together: one register, of AVX-512 sixteen floats or eight doubles, of AVX2 half as many; at least
/// four. Seen as groups of four where a function says "group".
template <class Real>
struct Simd {
  static constexpr int width = native_bytes / static_cast<int>(sizeof(Real)) > 4
                                   ? native_bytes / static_cast<int>(sizeof(Real))
                                   : 4;
  static constexpr int group_count = width / 4;
  using Index = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  typedef Real Vector __attribute__((vector_size(width * sizeof(Real))));    // NOLINT: `using` drops the attribute here
  typedef Index Integer __attribute__((vector_size(width * sizeof(Real))));  // NOLINT
  typedef Real Group __attribute__((vector_size(4 * sizeof(Real))));         // NOLINT
  Vector v;

  Simd() = default;
  Simd(Real a) : v(a - Vector{}) {}  // NOLINT: a number is a vector of equal lanes
  explicit Simd(const Vector& a) : v(a) {}

  static Simd load(const Real* a) {  // a is aligned to the register
    Simd r;
    std::memcpy(&r.v, __builtin_assume_aligned(a, sizeof r.v), sizeof r.v);
    return r;
  }
  void store(Real* a) const { std::memcpy(__builtin_assume_aligned(a, sizeof v), &v, sizeof v); }

  /// 16-bit integers, converted; a is aligned to half a register of floats.
  static Simd load(const std::int16_t* a) {
    // GCC 12 splits the conversion below in halves, which costs the kernel a tenth.
#if defined(__AVX512F__)
    if constexpr (width == 16)
      return Simd(_mm512_cvtepi32_ps(_mm512_cvtepi16_epi32(_mm256_load_si256(reinterpret_cast<const __m256i*>(a)))));
#elif defined(__AVX2__)
    if constexpr (width == 8)
      return Simd(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_load_si128(reinterpret_cast<const __m128i*>(a)))));
#endif
    typedef std::int16_t Shorts __attribute__((vector_size(width * 2)));  // NOLINT
    Shorts s;
    std::memcpy(&s, __builtin_assume_aligned(a, sizeof s), sizeof s);
    return Simd(__builtin_convertvector(__builtin_convertvector(s, Integer), Vector));
  }

  /// at(0), at(1) ...: Real arrays of four, aligned to a group. Put together in the register: a whole load from memory
  /// just stored in parts would wait for them.
  template <class At>
  static Simd gather(At at) {
    const auto group_at = [&](int k) {
      Group g;
      std::memcpy(&g, __builtin_assume_aligned(static_cast<const Real*>(at(k)), sizeof g), sizeof g);
      return g;
    };
#if defined(__AVX512F__)
    if constexpr (group_count == 4) {  // loads under a mask, where shuffles would crowd the kernel's
      __m512 all = _mm512_castps128_ps512(group_at(0));
      all = _mm512_mask_broadcast_f32x4(all, 0x00f0, group_at(1));
      all = _mm512_mask_broadcast_f32x4(all, 0x0f00, group_at(2));
      return Simd(_mm512_mask_broadcast_f32x4(all, 0xf000, group_at(3)));
    }
#endif
    if constexpr (group_count == 4) {
      const auto low = __builtin_shufflevector(group_at(0), group_at(1), 0, 1, 2, 3, 4, 5, 6, 7);
      const auto high = __builtin_shufflevector(group_at(2), group_at(3), 0, 1, 2, 3, 4, 5, 6, 7);
      return Simd(__builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15));
    } else if constexpr (group_count == 2) {
      return Simd(__builtin_shufflevector(group_at(0), group_at(1), 0, 1, 2, 3, 4, 5, 6, 7));
    } else {
      return Simd(group_at(0));
    }
  }
  /// a[index[0]], a[index[1]] ...
  static Simd at(const Real* a, const std::int32_t* index) {
#if defined(__AVX512F__)
    if constexpr (width == 16) return Simd(_mm512_i32gather_ps(_mm512_loadu_si512(index), a, sizeof(Real)));
#endif
    Simd r;
    for (int i = 0; i < width; ++i) r.v[i] = a[index[i]];
    return r;
  }
  /// The same group everywhere.
  static Simd repeat(const Real* a) {
    return gather([a](int) { return a; });
  }

  /// Group n.
  template <int n>
  Group group() const {
    return __builtin_shufflevector(v, v, 4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3);
  }
  /// Lane by lane (group 0 + group 1) + (group 2 + group 3), as many as there are.
  Group sumOfGroups() const {
    if constexpr (group_count == 4)
      return (group<0>() + group<1>()) + (group<2>() + group<3>());
    else if constexpr (group_count == 2)
      return group<0>() + group<1>();
    else
      return v;
  }

  // Friends, so that a plain number may stand on either side.
  friend Simd operator+(const Simd& a, const Simd& b) { return Simd(a.v + b.v); }
  friend Simd operator-(const Simd& a, const Simd& b) { return Simd(a.v - b.v); }
  friend Simd operator*(const Simd& a, const Simd& b) { return Simd(a.v * b.v); }
  friend Simd operator/(const Simd& a, const Simd& b) { return Simd(a.v / b.v); }
  friend Simd& operator+=(Simd& a, const Simd& b) { return a = a + b; }
  friend Simd& operator-=(Simd& a, const Simd& b) { return a = a - b; }
  friend Simd& operator*=(Simd& a, const Simd& b) { return a = a * b; }

  friend Simd max(const Simd& a, const Simd& b) { return Simd(a.v > b.v ? a.v : b.v); }
  /// a where x < y, else b.
  friend Simd whereLess(const Simd& x, const Simd& y, const Simd& a, const Simd& b) {
    return Simd(x.v < y.v ? a.v : b.v);
  }
};

/// Each lane's f, one by one.
template <class Real, class F>
Simd<Real> perLane(const Simd<Real>& a, F f) {
  Simd<Real> r;
  for (int i = 0; i < Simd<Real>::width; ++i) r.v[i] = f(a.v[i]);
  return r;
}

inline Simd<float> sqrt(const Simd<float>& a) {
  return perLane(a, [](float x) { return __builtin_sqrtf(x); });
}
inline Simd<double> sqrt(const Simd<double>& a) {
  return perLane(a, [](double x) { return __builtin_sqrt(x); });
}

namespace detail {
template <int K, class L, std::size_t... I>
L spread(const L& a, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, a.v, (I / 4 * 4 + K)...));
}
// In each group of four lanes of a and b: (a0 b0 a1 b1), (a2 b2 a3 b3), (a0 a1 b0 b1), (a2 a3 b2 b3).
// Shuffle indices from the width on name lanes of b.
template <class L, std::size_t... I>
L interleaveLow(const L& a, const L& b, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, b.v, (I / 4 * 4 + I % 4 / 2 + I % 2 * L::width)...));
}
template <class L, std::size_t... I>
L interleaveHigh(const L& a, const L& b, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, b.v, (I / 4 * 4 + I % 4 / 2 + 2 + I % 2 * L::width)...));
}
template <class L, std::size_t... I>
L joinLow(const L& a, const L& b, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, b.v, (I / 4 * 4 + I % 2 + I % 4 / 2 * L::width)...));
}
template <class L, std::size_t... I>
L joinHigh(const L& a, const L& b, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, b.v, (I / 4 * 4 + I % 2 + 2 + I % 4 / 2 * L::width)...));
}
// (a1 a0 a3 a2)
template <class L, std::size_t... I>
L swapPairs(const L& a, std::index_sequence<I...>) {
  return L(__builtin_shufflevector(a.v, a.v, (I ^ 1)...));
}
}  // namespace detail

/// Lane K of each group, in all four lanes of that group.
template <int K, class Real>
Simd<Real> spread(const Simd<Real>& a) {
  return detail::spread<K>(a, std::make_index_sequence<Simd<Real>::width>{});
}

/// Sums each group of a, b and c: group n of the result is (sum a_n, sum b_n, sum c_n, sum c_n).
template <class Real>
Simd<Real> groupSums(const Simd<Real>& a, const Simd<Real>& b, const Simd<Real>& c) {
  constexpr auto all = std::make_index_sequence<Simd<Real>::width>{};
  const auto ab = detail::interleaveLow(a, b, all) + detail::interleaveHigh(a, b, all);
  const auto cc = c + detail::swapPairs(c, all);
  return detail::joinLow(ab, cc, all) + detail::joinHigh(ab, cc, all);
}

/// The least of many numbers below 1 with its place, and how many are not positive.
template <class Real>
struct LeastOf {
  using L = Simd<Real>;
  L least;
  typename L::Integer first_place, not_positive{};
  LeastOf() : least(Real(1)), first_place(typename L::Integer{} - 1) {}

  /// Lanes of places `first`, `first + 1` ...; places ascend from call to call.
  void note(const L& x, int first) {
    const typename L::Integer less = x.v < least.v;
    least.v = less ? x.v : least.v;
    first_place = less ? first - typename L::Integer{} : first_place;
    not_positive -= x.v <= typename L::Vector{};
  }

  /// Lowers `value` and sets `place` where a noted lane is below, or equal at a lower place; adds to `count`.
  void find(Real& value, int& place, int& count) const {
    for (int i = 0; i < L::width; ++i) {
      count += static_cast<int>(not_positive[i]);
      const int here = static_cast<int>(first_place[i]) + i;
      if (first_place[i] < 0 || least.v[i] > value || (least.v[i] == value && here > place)) continue;
      value = least.v[i];
      place = here;
    }
  }
};

/// x^(-1/3) for x > 0: a guess from the exponent bits (3 % off) and three Newton steps to
/// float accuracy.
inline Simd<float> inverseCubeRoot(const Simd<float>& x) {
  using Lanes = Simd<float>;
  const auto bits = __builtin_bit_cast(Lanes::Integer, x.v);
  const auto third = __builtin_convertvector(__builtin_convertvector(bits, Lanes::Vector) * (1.0F / 3), Lanes::Integer);
  Lanes y(__builtin_bit_cast(Lanes::Vector, 0x54a2fa8c - third));
  for (int k = 0; k < 3; ++k) y = y * (4.0F / 3 - 1.0F / 3 * x * y * y * y);
  return y;
}
inline Simd<double> inverseCubeRoot(const Simd<double>& x) {
  return perLane(x, [](double a) { return 1 / std::cbrt(a); });
}

/// log2 m = 2 / ln 2 (t + t^3/3 + t^5/5 + ...) with t = (m - 1) / (m + 1), |t| < 0.172.
inline Simd<float>::Vector log2Series(const Simd<float>::Vector& t) {
  const Simd<float>::Vector t2 = t * t;
  return t * (2.885390082F + t2 * (0.961796694F + t2 * (0.577078016F + t2 * (0.412198583F + t2 * 0.320598898F))));
}

/// Base-2 logarithm of x > 0 (normal numbers), error below 2e-7 absolute plus 1e-7 relative.
inline Simd<float> log2(const Simd<float>& x) {
  using Lanes = Simd<float>;
  const auto bits = __builtin_bit_cast(Lanes::Integer, x.v);
  // Exponent chosen so that the mantissa lies in [1/sqrt 2, sqrt 2).
  const Lanes::Integer exponent = (bits - 0x3f3504f3) >> 23;
  const auto m = __builtin_bit_cast(Lanes::Vector, bits - (exponent << 23));
  return Lanes(__builtin_convertvector(exponent, Lanes::Vector) + log2Series((m - 1.0F) / (m + 1.0F)));
}

/// log2(y) for a y > 0 that is 1 + x: of x, error below 4e-7 relative, where y is near 1 and has lost digits of it.
inline Simd<float> log2OnePlus(const Simd<float>& x, const Simd<float>& y) {
  using Lanes = Simd<float>;
  const auto bits = __builtin_bit_cast(Lanes::Integer, y.v);
  const Lanes::Integer exponent = (bits - 0x3f3504f3) >> 23;
  const auto m = __builtin_bit_cast(Lanes::Vector, bits - (exponent << 23));
  const Lanes::Vector above = exponent == 0 ? x.v : m - 1.0F;
  return Lanes(__builtin_convertvector(exponent, Lanes::Vector) + log2Series(above / (above + 2.0F)));
}

inline Simd<double> log2(const Simd<double>& x) {
  return perLane(x, [](double a) { return std::log2(a); });
}
inline Simd<double> log2OnePlus(const Simd<double>& x, const Simd<double>& y) {
  const auto near = perLane(x, [](double a) { return std::log1p(a) / 0.69314718055994531; });
  return whereLess(x * x, Simd<double>(0.04), near, log2(y));
}

/// 2^x = (1 + part) 2^whole.
struct PowerOfTwo {
  Simd<float>::Vector part, factor;

  explicit PowerOfTwo(const Simd<float>& x) {
    using Lanes = Simd<float>;
    using Vector = Lanes::Vector;
    const Vector limited = x.v < -126.0F ? Vector{} - 126.0F : (x.v > 126.0F ? Vector{} + 126.0F : x.v);
    // Rounds to the nearest integer: adding 1.5 * 2^23 pushes the fraction out of the mantissa.
    const Vector shifted = limited + 12582912.0F;
    const Lanes::Integer whole = __builtin_bit_cast(Lanes::Integer, shifted) - 0x4b400000;
    const Vector f = (limited - (shifted - 12582912.0F)) * 0.69314718F;
    part = f * (1.0F + f * (0.5F + f * (0.16666667F + f * (0.041666668F + f * (0.0083333338F + f * 0.0013888889F)))));
    factor = __builtin_bit_cast(Vector, (whole + 127) << 23);
  }
};

/// 2^x for |x| < 126, error below 2e-7 relative.
inline Simd<float> exp2(const Simd<float>& x) {
  const PowerOfTwo power(x);
  return Simd<float>((1.0F + power.part) * power.factor);
}

/// 2^x - 1 for |x| < 126, error below 4e-7 relative where x is small.
inline Simd<float> exp2MinusOne(const Simd<float>& x) {
  const PowerOfTwo power(x);
  return Simd<float>(power.part * power.factor + (power.factor - 1.0F));
}

inline Simd<double> exp2(const Simd<double>& x) {
  return perLane(x, [](double a) { return std::exp2(a); });
}
inline Simd<double> exp2MinusOne(const Simd<double>& x) {
  return perLane(x, [](double a) { return std::expm1(a * 0.69314718055994531); });
}

}  // namespace PALPATE_KERNEL
}  // namespace palpate

#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace palpate {

// The widest vector of the target, in bytes.
#if defined(__AVX512F__)
inline constexpr int native_bytes = 64;
#elif defined(__AVX__)
inline constexpr int native_bytes = 32;
#else
inline constexpr int native_bytes = 16;
#endif

/// Sixteen numbers computed together: of floats one AVX-512 register, two of AVX2 or four of SSE, of doubles
/// twice as many, from one source. Seen as four groups of four where a function says "in each group".
template <class Real>
struct LanesOf {
  // A group of four stays within a part, so that shuffles do.
  static constexpr int width = std::max(4, native_bytes / static_cast<int>(sizeof(Real)));
  static constexpr int parts = 16 / width;
  using Index = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  typedef Real Vector __attribute__((vector_size(width * sizeof(Real))));    // NOLINT: `using` drops the attribute here
  typedef Index Integer __attribute__((vector_size(width * sizeof(Real))));  // NOLINT
  Vector v[parts];

  LanesOf() = default;
  LanesOf(Real a) {  // NOLINT: a number is a vector of equal lanes
    for (auto& p : v) p = a - Vector{};
  }

  static LanesOf load(const Real* a) {  // a is 64-byte aligned
    LanesOf r;
    std::memcpy(r.v, __builtin_assume_aligned(a, 64), sizeof r.v);
    return r;
  }
  void store(Real* a) const { std::memcpy(__builtin_assume_aligned(a, 64), v, sizeof v); }

  /// Four unaligned groups of four.
  static LanesOf gather(const Real* g0, const Real* g1, const Real* g2, const Real* g3) {
    LanesOf r;
    const Real* g[4] = {g0, g1, g2, g3};
    auto* to = reinterpret_cast<char*>(r.v);
    for (int k = 0; k < 4; ++k) std::memcpy(to + 4 * sizeof(Real) * k, g[k], 4 * sizeof(Real));
    return r;
  }

  // Friends, so that a plain number may stand on either side.
#define PALPATE_LANES_OP(op)                                                  \
  friend LanesOf operator op(const LanesOf& a, const LanesOf& b) {            \
    LanesOf r;                                                                \
    for (int i = 0; i < parts; ++i) r.v[i] = a.v[i] op b.v[i];                \
    return r;                                                                 \
  }
  PALPATE_LANES_OP(+)
  PALPATE_LANES_OP(-)
  PALPATE_LANES_OP(*)
  PALPATE_LANES_OP(/)
#undef PALPATE_LANES_OP

  friend LanesOf& operator+=(LanesOf& a, const LanesOf& b) { return a = a + b; }
  friend LanesOf& operator-=(LanesOf& a, const LanesOf& b) { return a = a - b; }

  friend LanesOf max(const LanesOf& a, const LanesOf& b) {
    LanesOf r;
    for (int i = 0; i < parts; ++i) r.v[i] = a.v[i] > b.v[i] ? a.v[i] : b.v[i];
    return r;
  }
  /// a where x < y, else b.
  friend LanesOf whereLess(const LanesOf& x, const LanesOf& y, const LanesOf& a, const LanesOf& b) {
    LanesOf r;
    for (int i = 0; i < parts; ++i) r.v[i] = x.v[i] < y.v[i] ? a.v[i] : b.v[i];
    return r;
  }
};

/// Each lane's f, one by one.
template <class Real, class F>
LanesOf<Real> perLane(const LanesOf<Real>& a, F f) {
  alignas(64) Real s[16];
  a.store(s);
  for (Real& x : s) x = f(x);
  return LanesOf<Real>::load(s);
}

template <class Real>
LanesOf<Real> sqrt(const LanesOf<Real>& a) {
  return perLane(a, [](Real x) { return std::sqrt(x); });
}

namespace detail {
template <class L, int K, std::size_t... I>
typename L::Vector spread(const typename L::Vector& a, std::index_sequence<I...>) {
  return __builtin_shuffle(a, typename L::Integer{static_cast<typename L::Index>(I / 4 * 4 + K)...});
}
// In each group of four lanes of a and b: (a0 b0 a1 b1), (a2 b2 a3 b3), (a0 a1 b0 b1), (a2 a3 b2 b3).
// Shuffle indices from the width on name lanes of b.
template <class L, std::size_t... I>
typename L::Vector interleaveLow(const typename L::Vector& a, const typename L::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, typename L::Integer{static_cast<typename L::Index>(I / 4 * 4 + I % 4 / 2 + I % 2 * L::width)...});
}
template <class L, std::size_t... I>
typename L::Vector interleaveHigh(const typename L::Vector& a, const typename L::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b,
                           typename L::Integer{static_cast<typename L::Index>(I / 4 * 4 + I % 4 / 2 + 2 + I % 2 * L::width)...});
}
template <class L, std::size_t... I>
typename L::Vector joinLow(const typename L::Vector& a, const typename L::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b, typename L::Integer{static_cast<typename L::Index>(I / 4 * 4 + I % 2 + I % 4 / 2 * L::width)...});
}
template <class L, std::size_t... I>
typename L::Vector joinHigh(const typename L::Vector& a, const typename L::Vector& b, std::index_sequence<I...>) {
  return __builtin_shuffle(a, b,
                           typename L::Integer{static_cast<typename L::Index>(I / 4 * 4 + I % 2 + 2 + I % 4 / 2 * L::width)...});
}
}  // namespace detail

/// Lane K of each group, in all four lanes of that group.
template <int K, class Real>
LanesOf<Real> spread(const LanesOf<Real>& a) {
  using L = LanesOf<Real>;
  L r;
  for (int i = 0; i < L::parts; ++i) r.v[i] = detail::spread<L, K>(a.v[i], std::make_index_sequence<L::width>{});
  return r;
}

/// Sums each group of a, b and c: group n of the result is (sum a_n, sum b_n, sum c_n, 0).
template <class Real>
LanesOf<Real> groupSums(const LanesOf<Real>& a, const LanesOf<Real>& b, const LanesOf<Real>& c) {
  using L = LanesOf<Real>;
  using Vector = typename L::Vector;
  L r;
  for (int i = 0; i < L::parts; ++i) {
    constexpr auto all = std::make_index_sequence<L::width>{};
    const Vector ab = detail::interleaveLow<L>(a.v[i], b.v[i], all) + detail::interleaveHigh<L>(a.v[i], b.v[i], all);
    const Vector c0 = detail::interleaveLow<L>(c.v[i], Vector{}, all) + detail::interleaveHigh<L>(c.v[i], Vector{}, all);
    r.v[i] = detail::joinLow<L>(ab, c0, all) + detail::joinHigh<L>(ab, c0, all);
  }
  return r;
}

/// x^(-1/3) for x > 0: a guess from the exponent bits (3 % off) and three Newton steps to
/// float accuracy.
inline LanesOf<float> inverseCubeRoot(const LanesOf<float>& x) {
  using Lanes = LanesOf<float>;
  Lanes y;
  for (int i = 0; i < Lanes::parts; ++i) {
    const auto bits = std::bit_cast<Lanes::Integer>(x.v[i]);
    const auto third = __builtin_convertvector(__builtin_convertvector(bits, Lanes::Vector) * (1.0F / 3), Lanes::Integer);
    y.v[i] = std::bit_cast<Lanes::Vector>(0x54a2fa8c - third);
  }
  for (int k = 0; k < 3; ++k) y = y * (4.0F / 3 - 1.0F / 3 * x * y * y * y);
  return y;
}
inline LanesOf<double> inverseCubeRoot(const LanesOf<double>& x) {
  return perLane(x, [](double a) { return 1 / std::cbrt(a); });
}

/// Base-2 logarithm of x > 0 (normal numbers), error below 2e-7 absolute plus 1e-7 relative.
inline LanesOf<float> log2(const LanesOf<float>& x) {
  using Lanes = LanesOf<float>;
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

inline LanesOf<double> log2(const LanesOf<double>& x) {
  return perLane(x, [](double a) { return std::log2(a); });
}

/// 2^x for |x| < 126, error below 2e-7 relative.
inline LanesOf<float> exp2(const LanesOf<float>& x) {
  using Lanes = LanesOf<float>;
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

inline LanesOf<double> exp2(const LanesOf<double>& x) {
  return perLane(x, [](double a) { return std::exp2(a); });
}

}  // namespace palpate

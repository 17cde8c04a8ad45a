#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

// A pressure that is bounded by a limit, and its energy: cell_volume.h.

/// p1 over shear modulus. The patches alone give way from 4.5 on, and where cells share points (cell_pairs.h) from 2.75.
/// At 1 torsion and indentation are as exact as at 2.5, but more nodes are looked at; at 2.5 the free block leaves the
/// closed form a little earlier, and points are squeezed more.
inline constexpr double pressure_limit = 1.5;

/// Share of its limit from which on a node's pressure counts.
inline constexpr double pressed_from = 0.8;

/// h of a pressure K theta.
template <class Real>
Real boundedEnergy(Real pressure, Real limit, Real bulk) {
  const Real p = std::abs(pressure);
  return p <= limit ? p * p / (2 * bulk) : limit * (p - limit / 2) / bulk;
}

template <class Real>
Real bounded(Real pressure, Real limit) {
  return std::clamp(pressure, -limit, limit);
}

/// How much a node counts as pressed: 0 up to pressed_from of its limit, 1 from the limit on.
template <class Real>
Real pressedShare(Real pressure, Real limit) {
  constexpr Real from = static_cast<Real>(pressed_from);
  const Real p = std::abs(pressure);
  if (!(p > from * limit)) return 0;
  return p < limit ? (p / limit - from) / (1 - from) : 1;
}

}  // namespace palpate

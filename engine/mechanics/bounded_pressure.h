#pragma once

#include <algorithm>

namespace palpate {

// A pressure that is bounded on the side of compression, and its energy: cell_volume.h.

/// p1 over shear modulus. The patches alone give way from 4.5 on, and where cells share points (cell_pairs.h) from
/// 2.75. At 2.5 confined pairs are at their limit, and free blocks leave the closed form earlier; at 1 more nodes are
/// looked at for the same forces.
inline constexpr double pressure_limit = 1.5;

/// Share of its limit from which on a node's pressure counts.
inline constexpr double pressed_from = 0.8;

/// Friction over shear modulus that holds a node of the skin. (Blocks between plates, nu 0.49, coefficients of 0.3 to
/// 1: from 0.05 to 0.2 forces are alike to 0.2 %; 0.5 and more leave them too stiff, and trembling.)
inline constexpr double held_from = 0.1;

/// h of a pressure K theta, which is negative where the tissue is pressed.
template <class Real>
Real boundedEnergy(Real pressure, Real limit, Real bulk) {
  return pressure >= -limit ? pressure * pressure / (2 * bulk) : limit * (-pressure - limit / 2) / bulk;
}

template <class Real>
Real bounded(Real pressure, Real limit) {
  return std::max(pressure, -limit);
}

/// How much a node counts as pressed: 0 up to pressed_from of its limit, 1 from the limit on.
template <class Real>
Real pressedShare(Real pressure, Real limit) {
  constexpr Real from = static_cast<Real>(pressed_from);
  if (!(-pressure > from * limit)) return 0;
  return -pressure < limit ? (-pressure / limit - from) / (1 - from) : 1;
}

/// Which share of a node's pressure friction leaves to its cells.
/// @param friction  Pa, that holds the node
template <class Real>
Real looseShare(Real friction, Real shear) {
  const Real holds = static_cast<Real>(held_from) * shear;
  if (!(friction < holds)) return 0;
  return friction > 0 ? 1 - friction / holds : Real(1);  // a row's N may be negative
}

}  // namespace palpate

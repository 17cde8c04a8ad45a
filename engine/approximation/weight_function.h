#pragma once

namespace palpate {

/// Quartic spline weight 1 - 6 s^2 + 8 s^3 - 3 s^4 for s = distance / support radius in [0, 1];
/// zero beyond. Twice continuously differentiable (paper section 2.1).
inline double quarticSpline(double s) { return s >= 1 ? 0 : 1 + s * s * (-6 + s * (8 - 3 * s)); }

/// (dw/ds) / s = -12 (1 - s)^2: finite at s = 0, so that the gradient of the weight with
/// respect to x is quarticSplineSlope(s) * (x - X_j) / R_j^2.
inline double quarticSplineSlope(double s) { return s >= 1 ? 0 : -12 * (1 - s) * (1 - s); }

/// A factor for the weight of a node that the approximation goes through: large at the node, so that there the field is
/// its parameter but for 1 / (1 + strength / floor), and 1 + strength at the end of its support (Lancaster and
/// Salkauskas 1981, with weights that stay finite). Its slope is pinnedSlope(s) * (x - X_j) / R_j^2.
inline constexpr double pin_strength = 0.4, pin_floor = 1e-4;
inline double pinnedFactor(double s) { return 1 + pin_strength / (s * s + pin_floor); }
inline double pinnedSlope(double s) { return -2 * pin_strength / ((s * s + pin_floor) * (s * s + pin_floor)); }

}  // namespace palpate

#pragma once

namespace palpate {

/// Quartic spline weight 1 - 6 s^2 + 8 s^3 - 3 s^4 for s = distance / support radius in [0, 1];
/// zero beyond. Twice continuously differentiable (paper section 2.1).
inline double quarticSpline(double s) { return s >= 1 ? 0 : 1 + s * s * (-6 + s * (8 - 3 * s)); }

/// (dw/ds) / s = -12 (1 - s)^2: finite at s = 0, so that the gradient of the weight with
/// respect to x is quarticSplineSlope(s) * (x - X_j) / R_j^2.
inline double quarticSplineSlope(double s) { return s >= 1 ? 0 : -12 * (1 - s) * (1 - s); }

}  // namespace palpate

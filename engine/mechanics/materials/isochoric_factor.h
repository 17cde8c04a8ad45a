#pragma once

#include <cmath>

#include "base/kernel_namespace.h"
#include "mechanics/materials/material.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

/// g(J) = J^e and its derivative. Below Jc = min_isochoric_J the tangent there, so that energy and stress stay finite
/// and consistent for inverted F; for e > 0, whose tangent would go below zero, and with it the energy of a crushed
/// point without bound, Jc^e / (1 - e (J / Jc - 1)), which has the same slope at Jc.
struct IsochoricFactor {
  double value, slope;
  IsochoricFactor(double J, double e) {
    const double Jc = J < Material::min_isochoric_J ? Material::min_isochoric_J : J;
    value = std::pow(Jc, e);
    slope = e * value / Jc;
    if (e < 0) {
      value += slope * (J - Jc);
    } else {
      const double f = 1 / (1 - e * (J / Jc - 1));
      value *= f;
      slope *= f * f;
    }
  }
};

/// dJ/dF.
inline Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c.col(0) = F.col(1).cross(F.col(2));
  c.col(1) = F.col(2).cross(F.col(0));
  c.col(2) = F.col(0).cross(F.col(1));
  return c;
}

}  // namespace PALPATE_KERNEL
}  // namespace palpate

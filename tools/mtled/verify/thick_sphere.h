#pragma once

#include "mechanics/materials/material.h"

namespace palpate::tools {

/// A sphere with a hollow in its middle under pressure from inside, of any isotropic law:
///
///   dP_r/dR = 2 (P_t - P_r) / R,  dr/dR = l_r,   P(diag(l_r, l_t, l_t)) = (P_r, P_t, P_t),  l_t = r / R
///
/// with P_r = 0 outside, integrated inwards by Runge and Kutta's rule of fourth order; the place of the outside is
/// found by bisection so that the inner hoop stretch is the one that was asked for. For nu to 1/2 Green and Zerna's
///   p = mu/2 (4/l_b + 1/l_b^4 - 4/l_a - 1/l_a^4)
/// Test: validation/surface_load_test.cpp
class ThickSphere {
 public:
  /// @param a, b  m, radii at rest  @param stretch  of the hollow's radius
  ThickSphere(const Material& material, double a, double b, double stretch);

  double pressure() const { return pressure_; }           // Pa, on the hollow's present face
  double outerStretch() const { return outer_stretch_; }  // of the radius outside

 private:
  double pressure_ = 0, outer_stretch_ = 1;
};

}  // namespace palpate::tools

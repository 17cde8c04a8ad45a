#pragma once

#include <vector>

#include "approximation/mmls.h"
#include "approximation/neighbours.h"
#include "approximation/shape_functions.h"
#include "base/types.h"

namespace palpate {

/// The integrand that drives the adaptive quadrature, paper eq. 30:
///
///   f(x) = (sum_k N_k,x(x)^2, sum_k N_k,y(x)^2, sum_k N_k,z(x)^2),   1/m^2
///
/// at least as rough as the products of gradients in the weak form. Not finite (NaN) where the support is
/// inadmissible.
///
/// Keeps scratch: one object per thread. Copies are independent.
/// Test: discretization/cells/adaptive_quadrature_test.cpp
class GradientEnergy {
 public:
  /// @param X, radius   nodes, m, and their supports' radii, m (node_count); kept by reference
  /// @param neighbours  of the same X and radius; kept by reference
  GradientEnergy(const std::vector<Vec3>& X, const std::vector<double>& radius, const Neighbours& neighbours,
                 const MmlsOptions& options)
      : X_(&X), radius_(&radius), neighbours_(&neighbours), mmls_(options) {}

  Vec3 operator()(const Vec3& x);

 private:
  const std::vector<Vec3>* X_;
  const std::vector<double>* radius_;
  const Neighbours* neighbours_;
  Mmls<3> mmls_;
  std::vector<int> support_;
  std::vector<Vec3> support_X_;
  std::vector<double> support_radius_;
};

}  // namespace palpate

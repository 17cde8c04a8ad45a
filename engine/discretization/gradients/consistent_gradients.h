#pragma once

#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "discretization/gradients/boundary_points.h"

namespace palpate {

/// What correctGradients found and did.
struct GradientCorrection {
  double violation_before = 0;  // |sum_q V_q gradN_i - int N_i n dS| over |int N_i n dS|, 2-norms over nodes
  double violation_after = 0;
  int iterations = 0;  // of the conjugate gradients
};

/// Makes gradients at integration points satisfy the discrete divergence theorem
///   sum_q V_q gradN_i(X_q) = int_boundary N_i n dS     for each node i.
/// The quadrature of rational shape functions violates it, and that is most of the error of a meshless Galerkin
/// method: a linear displacement field is then no equilibrium under its own surface tractions.
/// The change is the smallest in the norm sum_q V_q |dB_iq|^2 that also keeps sum_i B_iq = 0 and
/// sum_i X_i (x) B_iq = I at each point:
///   dB_iq = lambda_i - p_i . M_q^-1 sum_j p_j lambda_j,   p = (1, (X - x_q)/R),  M_q = sum_j p_j p_j^T
/// with lambda from one symmetric node-by-node system for each component (gradient_system.h), solved by conjugate
/// gradients with a coarse correction (coarse_correction.h). The null space of the system is the linear fields; the
/// right-hand side is orthogonal to it, so a solution exists. With Jacobi's preconditioner alone 4,801 nodes took 247
/// iterations to 1e-6 instead of 19, and 35,499 nodes were at 3e-3 after 400 instead of at 1e-6 after 15. The same
/// gradients serve trial and test functions, so momentum and energy stay exact.
///
/// @param shape       rows of the integration points; gradN is changed
/// @param point_X     m, volume m^3                                (point_count)
/// @param X           nodes, m                                     (node_count)
/// @param boundary    samples of the boundary integral; their rule decides how accurate the gradients become
/// @param at_boundary N at these samples, one row each
/// @param tolerance   of the relative residual
/// On all cores; the result does not depend on their number.
/// Test: discretization/gradients/consistent_gradients_test.cpp
GradientCorrection correctGradients(ShapeTable& shape, const std::vector<Vec3>& point_X,
                                    const std::vector<double>& volume, const std::vector<Vec3>& X,
                                    const BoundaryPoints& boundary, const ShapeTable& at_boundary,
                                    double tolerance = 1e-6);

}  // namespace palpate

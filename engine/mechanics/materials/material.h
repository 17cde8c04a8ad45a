#pragma once

#include <array>

#include "base/types.h"

namespace palpate {

/// Isotropic hyperelastic material with density: a small value type.
///
/// Neo-Hookean:  W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2
/// Ogden (paper eq. 32):
///   W = sum_k 2 mu_k / a_k^2 (J^(-a_k/3) (l1^a_k + l2^a_k + l3^a_k) - 3) + K/2 (J - 1)^2,  K = 2/D1
/// with the principal stretches l1, l2, l3.
struct Material {
  enum class Kind { NeoHookean, Ogden };
  static constexpr int max_terms = 6;

  Kind kind = Kind::NeoHookean;
  double shear_modulus = 0;                     // Pa, at rest (Ogden: sum of mu_k)
  double bulk_modulus = 0;                      // Pa
  double density = 1000;                        // kg/m^3
  int term_count = 0;                           // Ogden
  std::array<double, max_terms> mu{}, alpha{};  // Ogden: Pa, 1
  // Optional barrier against collapse, for J < barrier_J0: the energies above permit J = 0 at a finite pressure.
  //   W += K b (J ln(J / J0) - J + J0),  p += K b ln(J / J0).  It departs from eq. 32; 0 is none.
  double barrier_strength = 0;  // b
  double barrier_J0 = 0.5;

  static Material neoHookean(double young, double poisson, double density);
  static Material ogden(const double* mu, const double* alpha, int term_count, double D1, double density);

  /// Strain energy per reference volume, J/m^3. F is the deformation gradient.
  double energy(const Mat3& F) const;

  /// First Piola-Kirchhoff stress dW/dF, Pa. Finite also for inverted F (det F <= 0),
  /// where the isochoric factor follows its tangent at J = min_isochoric_J.
  Mat3 firstPiola(const Mat3& F) const;

  /// The same with the volumetric pressure K (J - 1) replaced by `pressure`, Pa (node_patch.h). The barrier's
  /// comes on top in both: it guards the point's own J.
  Mat3 firstPiola(const Mat3& F, double pressure) const;

  /// K b ln(J / J0) below J0, with its tangent below min_isochoric_J; Pa.
  double barrierPressure(double J) const;

  /// P-wave modulus at rest, K + 4/3 mu, Pa.
  double waveModulus() const { return bulk_modulus + 4.0 / 3.0 * shear_modulus; }

  /// Below this J the isochoric factor J^(-a/3) continues along its tangent, so that an inverted point gets a
  /// finite force that pushes it back. A state that gets here is flagged, not trusted.
  static constexpr double min_isochoric_J = 0.02;
};

/// von Mises equivalent of the Cauchy stress P F^T / J, Pa.
double vonMises(const Mat3& P, const Mat3& F);

}  // namespace palpate

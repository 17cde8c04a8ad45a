#pragma once

#include <span>
#include <string_view>
#include <type_traits>

#include "base/types.h"

namespace palpate {

struct MaterialLaw;

/// Hyperelastic material with density: a law (laws.h) and the values of its parameters. A small value type, which
/// threads pass to each other.
///
///   W = W_law(F) + K/2 (J - 1)^2          the law's part, of J^(-2/3) C and stretches of fibres, and the volume
struct Material {
  static constexpr int max_terms = 6;  // entries of a parameter that is a list
  static constexpr int max_values = 2 * max_terms + 1;
  static constexpr int max_relaxation_terms = 3;

  int law = 0;                 // place in materialLaws()
  int term_count = 0;          // entries in use of each list
  double value[max_values]{};  // the law's parameters in the order of its list; one that is a list takes max_terms

  // Follow from the parameters (set).
  double shear_modulus = 0;  // Pa, at rest
  double bulk_modulus = 0;   // Pa, K
  double fibre_modulus = 0;  // Pa, at rest under tension: what fibres add along `fibre`; 0 where the law is isotropic
  double fibre[3]{};         // their unit direction at rest

  // Parameters of every law.
  double density = 1000;  // kg/m^3
  // Optional barrier against collapse, for J < barrier_J0: the energy above permits J = 0 at a finite pressure.
  //   W += K b (J ln(J / J0) - J + J0),  p += K b ln(J / J0).  It departs from paper eq. 32; 0 is none.
  double barrier_strength = 0;  // b
  double barrier_J0 = 0.5;
  // Optional relaxation of the isochoric stress (relaxation.h): pairs of the share g_i that relaxes and its time tau_i,
  // s. The law's moduli are those at once.
  int relaxation_count = 0;
  double relaxation[2 * max_relaxation_terms]{};

  /// A material of the law with this name: values not set yet are their defaults, or 0.
  /// Throws std::invalid_argument where there is no such law.
  static Material of(std::string_view law);

  static Material neoHookean(double young, double poisson, double density);
  static Material ogden(const double* mu, const double* alpha, int term_count, double D1, double density);

  const MaterialLaw& lawDescription() const;

  /// Sets a parameter by its name, and with it the moduli at rest. A list sets term_count: a law's lists are equally
  /// long once all are set. Throws std::invalid_argument where the law has no such parameter, or too many entries.
  Material& set(std::string_view parameter, std::span<const double> values);
  Material& set(std::string_view parameter, double number) { return set(parameter, std::span(&number, 1)); }

  /// Values of a parameter, by its name. Throws std::invalid_argument where the law has no such parameter.
  std::span<const double> get(std::string_view parameter) const;

  /// Makes the moduli at rest what the law says of the values.
  void updateModuli();

  /// Strain energy per reference volume, J/m^3. F is the deformation gradient.
  double energy(const Mat3& F) const;

  /// First Piola-Kirchhoff stress dW/dF, Pa. Finite also for inverted F (det F <= 0),
  /// where the isochoric factor goes on with its slope at J = min_isochoric_J.
  Mat3 firstPiola(const Mat3& F) const;

  /// The same with the volumetric pressure K (J - 1) replaced by `pressure`, Pa (node_patch.h). The barrier's
  /// comes on top in both: it guards the point's own J.
  Mat3 firstPiola(const Mat3& F, double pressure) const;

  /// K b ln(J / J0) below J0, with its tangent below min_isochoric_J; Pa.
  double barrierPressure(double J) const;

  /// P-wave modulus at rest, K + 4/3 mu, Pa; along the fibres where there are some.
  double waveModulus() const { return bulk_modulus + 4.0 / 3.0 * shear_modulus + fibre_modulus; }

  /// Of the isochoric stress, what is left after a long time: 1 - sum g.
  double longTermShare() const;

  bool operator==(const Material&) const = default;

  /// Below this J the isochoric factor J^(-a/3) continues with its slope (IsochoricFactor), so that an inverted point
  /// gets a finite force that pushes it back. A state that gets here is flagged, not trusted.
  static constexpr double min_isochoric_J = 0.02;
};
static_assert(std::is_trivially_copyable_v<Material>);  // it goes through lock-free queues

/// The material with all its stiffnesses times `factor`: parameters in Pa are multiplied, those in 1/Pa divided. What
/// relaxes, and how fast, stays.
Material stiffened(Material material, double factor);

/// von Mises equivalent of the Cauchy stress P F^T / J, Pa.
double vonMises(const Mat3& P, const Mat3& F);

}  // namespace palpate

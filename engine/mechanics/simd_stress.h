#pragma once

#include "base/simd.h"
#include "mechanics/materials/material.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

/// Nine numbers of a tensor for as many points as there are lanes, row by row.
template <class Real>
struct SimdTensor {
  Simd<Real> a[9];
  Simd<Real>& operator[](int k) { return a[k]; }
  const Simd<Real>& operator[](int k) const { return a[k]; }
};

/// J - 1 = det(I + H) - 1 = tr H + (principal 2x2 minors of H) + det H: no cancellation.
template <class Real>
[[gnu::always_inline]] inline Simd<Real> volumeChange(const SimdTensor<Real>& H) {
  using Lanes = Simd<Real>;
  const Lanes m0 = H[4] * H[8] - H[5] * H[7];
  const Lanes m1 = H[0] * H[8] - H[2] * H[6];
  const Lanes m2 = H[0] * H[4] - H[1] * H[3];
  const Lanes det = H[0] * m0 + H[1] * (H[5] * H[6] - H[3] * H[8]) + H[2] * (H[3] * H[7] - H[4] * H[6]);
  return (H[0] + H[4] + H[8]) + ((m0 + m1 + m2) + det);
}

/// F = I + H, its cofactor dJ/dF, and J. Inline: a call would pass 27 registers through memory.
template <class Real>
[[gnu::always_inline]] inline Simd<Real> volumeRatioAndCofactor(const SimdTensor<Real>& H, SimdTensor<Real>& F,
                                                                SimdTensor<Real>& cof, Simd<Real>& J_minus_1) {
  F = H;
  F[0] += 1.0F;
  F[4] += 1.0F;
  F[8] += 1.0F;
  cof[0] = F[4] * F[8] - F[5] * F[7];
  cof[1] = F[5] * F[6] - F[3] * F[8];
  cof[2] = F[3] * F[7] - F[4] * F[6];
  cof[3] = F[2] * F[7] - F[1] * F[8];
  cof[4] = F[0] * F[8] - F[2] * F[6];
  cof[5] = F[1] * F[6] - F[0] * F[7];
  cof[6] = F[1] * F[5] - F[2] * F[4];
  cof[7] = F[2] * F[3] - F[0] * F[5];
  cof[8] = F[0] * F[4] - F[1] * F[3];
  J_minus_1 = volumeChange<Real>(H);
  return J_minus_1 + 1.0F;
}

// A law's Lanes give the first Piola-Kirchhoff stress of some points from their displacement gradients H, in float32 or
// double: the fast twins of Material::firstPiola. J - 1 comes from H without cancellation, since the bulk modulus
// multiplies its error.

/// What a stress evaluation knows of its points besides the stress.
///
/// The law bounds its own tangent. No small wave sees a modulus above
///   c = squeeze s^2 + other,   s the largest singular value of cof F, that is J over the least principal stretch
/// the largest eigenvalue of the acoustic tensor a . (d^2 W / dF dF : a (x) n) . n over all unit n, a; at rest it is
/// Material::waveModulus(). For isotropic laws it is that of a = n along the least stretch l, d^2 W / dl^2 (all of the
/// register have their largest there: mechanics/materials/tangent_bound_test.cpp), and a pressure, which is linear in
/// cof F, has no part in it. s is found later from cof2 and J, and only where tissue is squeezed (local_mass.h).
template <class Real>
struct PointStateOf {
  Simd<Real> J, J_minus_1;
  Simd<Real> energy;          // J/m^3; p (J - 1) / 2 for the volume, which over all points is also the patches' energy
  Simd<Real> cof2;            // |cof F|^2, 3 at rest
  Simd<Real> squeeze, other;  // Pa
};

template <class Real>
Simd<Real> squaredNorm(const SimdTensor<Real>& t) {
  Simd<Real> sum = t[0] * t[0];
  for (int k = 1; k < 9; ++k) sum += t[k] * t[k];
  return sum;
}

/// The barrier of Material::barrierPressure; nothing where the material has none.
template <class Real>
struct BarrierLanes {
  Real strength, J0;
  explicit BarrierLanes(const Material& m)
      : strength(static_cast<Real>(m.bulk_modulus * m.barrier_strength)), J0(static_cast<Real>(m.barrier_J0)) {}

  /// Whether it acts on one of the lanes: nearly always it acts on none, and costs a comparison.
  bool acts(const Simd<Real>& J) const {
    if (strength == 0) return false;
    const typename Simd<Real>::Integer below = J.v < Simd<Real>(J0).v;
    typename Simd<Real>::Index any = 0;
    for (int i = 0; i < Simd<Real>::width; ++i) any |= below[i];
    return any != 0;
  }

  void addTo(Simd<Real>& pressure, Simd<Real>& energy, const Simd<Real>& J) const {
    if (!acts(J)) return;
    const Simd<Real> none = Real(0), Jc = max(J, Simd<Real>(static_cast<Real>(Material::min_isochoric_J))), d = J - Jc;
    const Simd<Real> logarithm = log2(Jc / J0) * static_cast<Real>(0.6931471805599453);
    pressure += whereLess(J, Simd<Real>(J0), strength * (logarithm + d / Jc), none);
    energy += whereLess(J, Simd<Real>(J0), strength * (J * logarithm - Jc + J0 + d * d / (Jc * Real(2))), none);
  }

  /// Adds the barrier's part of the volume's stiffness, K b / J, to PointStateOf::squeeze.
  void stiffen(Simd<Real>& squeeze, const Simd<Real>& J) const {
    if (!acts(J)) return;
    const Simd<Real> none = Real(0), Jc = max(J, Simd<Real>(static_cast<Real>(Material::min_isochoric_J)));
    squeeze += whereLess(J, Simd<Real>(J0), strength / Jc, none);
  }
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

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

// The materials below give the first Piola-Kirchhoff stress of some points from their displacement gradients H,
// in float32 or double: the fast twins of Material::firstPiola. J - 1 comes from H without cancellation,
// since the bulk modulus multiplies its error.

/// What a stress evaluation knows of its points besides the stress.
template <class Real>
struct PointStateOf {
  Simd<Real> J, J_minus_1;
  Simd<Real> energy;  // J/m^3; p (J - 1) / 2 for the volume, which over all points is also the node patches' energy
  Simd<Real> cof2;    // |cof F|^2, 3 at rest: how much stiffer the volume has become
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

  void addTo(Simd<Real>& pressure, Simd<Real>& energy, const Simd<Real>& J) const {
    if (strength == 0) return;
    const Simd<Real> none = Real(0), Jc = max(J, Simd<Real>(static_cast<Real>(Material::min_isochoric_J))), d = J - Jc;
    const Simd<Real> logarithm = log2(Jc / J0) * static_cast<Real>(0.6931471805599453);
    pressure += whereLess(J, Simd<Real>(J0), strength * (logarithm + d / Jc), none);
    energy += whereLess(J, Simd<Real>(J0), strength * (J * logarithm - Jc + J0 + d * d / (Jc * Real(2))), none);
  }
};

template <class Real>
struct NeoHookeanLanes {
  using Lanes = Simd<Real>;
  using SimdTensors = SimdTensor<Real>;
  Real mu, K;
  BarrierLanes<Real> barrier;
  explicit NeoHookeanLanes(const Material& m)
      : mu(static_cast<Real>(m.shear_modulus)), K(static_cast<Real>(m.bulk_modulus)), barrier(m) {}

  /// @param patch_pressure  replaces K (J - 1) where the scene averages volume over node patches; or null
  PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Lanes* patch_pressure = nullptr) const {
    SimdTensors F, cof;
    PointStateOf<Real> state;
    const Lanes J = state.J = volumeRatioAndCofactor<Real>(H, F, cof, state.J_minus_1);
    const Lanes I1 = squaredNorm(F);
    // g(J) = J^(-2/3) and its slope, with the tangent below min_isochoric_J.
    const Lanes Jc = max(J, Lanes(static_cast<Real>(Material::min_isochoric_J)));
    const Lanes y = inverseCubeRoot(Jc);
    Lanes g = y * y;
    const Lanes slope = Lanes(Real(-2) / 3) * g / Jc;
    g += slope * (J - Jc);
    const Lanes a = g * mu;
    Lanes p = patch_pressure ? *patch_pressure : state.J_minus_1 * K;
    state.energy = Real(0.5) * (mu * (g * I1 - Real(3)) + p * state.J_minus_1);
    barrier.addTo(p, state.energy, J);
    const Lanes b = slope * I1 * (Real(0.5) * mu) + p;
    for (int k = 0; k < 9; ++k) P[k] = a * F[k] + b * cof[k];
    state.cof2 = squaredNorm(cof);
    return state;
  }
};

/// Eigenvalues and eigenvectors of symmetric 3x3 matrices by cyclic Jacobi: no branch, and
/// indifferent to repeated eigenvalues.
template <class Real>
struct SymmetricEigenLanes {
  using Lanes = Simd<Real>;
  using SimdTensors = SimdTensor<Real>;
  Lanes a[3][3], v[3][3];

  template <int p, int q, int r>
  void rotate() {
    // tan(theta) of the rotation that clears a[p][q]: t = sign(d) 2 a_pq / (|d| + sqrt(d^2 + 4 a_pq^2))
    const Lanes d = a[q][q] - a[p][p], apq2 = a[p][q] * 2.0F;
    const Lanes magnitude = max(d, Lanes(0.0F) - d);
    const Lanes denominator = magnitude + sqrt(d * d + apq2 * apq2) + Real(1e-30);
    const Lanes t = whereLess(d, 0.0F, Lanes(0.0F) - apq2, apq2) / denominator;
    const Lanes c = Lanes(1.0F) / sqrt(t * t + 1.0F), s = t * c;
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0.0F;
    const Lanes arp = a[r][p], arq = a[r][q];
    a[r][p] = a[p][r] = c * arp - s * arq;
    a[r][q] = a[q][r] = s * arp + c * arq;
    for (auto& row : v) {
      const Lanes vp = row[p], vq = row[q];
      row[p] = c * vp - s * vq;
      row[q] = s * vp + c * vq;
    }
  }

  /// Starts from C = F^T F. Four sweeps leave off-diagonals below float rounding, six below double.
  explicit SymmetricEigenLanes(const SimdTensors& F) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        a[i][j] = F[i] * F[j] + F[3 + i] * F[3 + j] + F[6 + i] * F[6 + j];
        v[i][j] = i == j ? 1.0F : 0.0F;
      }
    constexpr int sweeps = sizeof(Real) == 4 ? 4 : 6;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      rotate<0, 1, 2>();
      rotate<0, 2, 1>();
      rotate<1, 2, 0>();
    }
  }
};

template <class Real>
struct OgdenLanes {
  using Lanes = Simd<Real>;
  using SimdTensors = SimdTensor<Real>;
  int terms;
  Real K;
  Real mu[Material::max_terms], alpha[Material::max_terms];
  BarrierLanes<Real> barrier;
  explicit OgdenLanes(const Material& m) : terms(m.term_count), K(static_cast<Real>(m.bulk_modulus)), barrier(m) {
    // An array's [] is an inline function of std (kernel_namespace.h).
    const auto* m_mu = reinterpret_cast<const double*>(&m.mu);
    const auto* m_alpha = reinterpret_cast<const double*>(&m.alpha);
    for (int k = 0; k < terms; ++k) {
      mu[k] = static_cast<Real>(m_mu[k]);
      alpha[k] = static_cast<Real>(m_alpha[k]);
    }
  }

  /// @param patch_pressure  as in NeoHookeanLanes
  PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Lanes* patch_pressure = nullptr) const {
    SimdTensors F, cof;
    PointStateOf<Real> state;
    const Lanes J = state.J = volumeRatioAndCofactor<Real>(H, F, cof, state.J_minus_1);
    const SymmetricEigenLanes<Real> eigen(F);
    const Lanes Jc = max(J, Lanes(static_cast<Real>(Material::min_isochoric_J)));
    const Lanes log_J = log2(Jc);
    Lanes squared[3], log_squared[3], s[3];
    for (int i = 0; i < 3; ++i) {
      squared[i] = max(eigen.a[i][i], Lanes(Real(1e-12)));
      log_squared[i] = log2(squared[i]);
      s[i] = 0.0F;
    }
    Lanes pressure = patch_pressure ? *patch_pressure : state.J_minus_1 * K;
    state.energy = Real(0.5) * pressure * state.J_minus_1;
    barrier.addTo(pressure, state.energy, J);
    for (int k = 0; k < terms; ++k) {
      const Real al = alpha[k];
      Lanes g = exp2(log_J * (-al / 3));
      const Lanes slope = g * (-al / 3) / Jc;
      g += slope * (J - Jc);
      Lanes sum = 0.0F;
      for (int i = 0; i < 3; ++i) {
        const Lanes power = exp2(log_squared[i] * (Real(0.5) * al));
        s[i] += g * power * (2 * mu[k] / al) / squared[i];
        sum += power;
      }
      const Real factor = 2 * mu[k] / (al * al);
      pressure += slope * sum * factor;
      state.energy += factor * (g * sum - Real(3));
    }
    // S = sum s_i n_i (x) n_i,  P = F S + pressure cof F
    for (int i = 0; i < 3; ++i) {
      Lanes Fn[3];
      for (int r = 0; r < 3; ++r)
        Fn[r] = (F[3 * r] * eigen.v[0][i] + F[3 * r + 1] * eigen.v[1][i] + F[3 * r + 2] * eigen.v[2][i]) * s[i];
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const Lanes term = Fn[r] * eigen.v[c][i];
          P[3 * r + c] = i == 0 ? term : P[3 * r + c] + term;
        }
    }
    for (int k = 0; k < 9; ++k) P[k] += pressure * cof[k];
    state.cof2 = squaredNorm(cof);
    return state;
  }
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

#pragma once

#include "mechanics/relaxation.h"
#include "mechanics/simd_stress.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

/// Some points on their way through relax, in memory: registers that are handed on would slow down those who have
/// nothing to relax.
template <class Real>
struct alignas(64) RelaxingPoints {
  static constexpr int width = Simd<Real>::width;
  Real H[9][width];    // displacement gradient
  Real P[9][width];    // the law's stress, Pa; becomes what is left of it
  Real energy[width];  // of RelaxedStress
  Real power[width];
};

/// The fast twin of relaxedStress.
/// @param Z  [term][6][16] of the points' batch, at the first of them; null: the equilibrium
template <class Real>
[[gnu::noinline]] void relax(const RelaxationStep& step, Real* Z, RelaxingPoints<Real>& points) {
  using Lanes = Simd<Real>;
  constexpr int row[6] = {0, 1, 2, 1, 0, 0}, column[6] = {0, 1, 2, 2, 2, 1};
  SimdTensor<Real> H, P, F, cof;
  for (int k = 0; k < 9; ++k) {
    H[k] = Lanes::load(points.H[k]);
    P[k] = Lanes::load(points.P[k]);
  }
  Lanes J_minus_1;
  const Lanes J = volumeRatioAndCofactor<Real>(H, F, cof, J_minus_1);
  const Lanes least = static_cast<Real>(Material::min_isochoric_J), Jc = max(J, least), none = Real(0);
  const Lanes y = inverseCubeRoot(Jc), y2 = y * y, third = Lanes(Real(1) / 3) / Jc;
  Lanes PF = P[0] * F[0];
  for (int k = 1; k < 9; ++k) PF += P[k] * F[k];
  PF *= third;
  Lanes S[6], C[6], Q[6], flow[6];
  for (int n = 0; n < 6; ++n) {
    const int r = row[n], c = column[n];
    S[n] = C[n] = Q[n] = flow[n] = none;
    for (int k = 0; k < 9; k += 3) {
      S[n] += cof[k + r] * (P[k + c] - PF * cof[k + c]);
      C[n] += F[k + r] * F[k + c];
    }
    S[n] = whereLess(J, least, none, y * S[n]);
    C[n] *= y2;
  }
  for (int i = 0; i < step.term_count; ++i) {
    const RelaxationStep::Term& term = step.term[i];
    const Lanes now = static_cast<Real>(term.now), later = static_cast<Real>(term.later),
                decay = static_cast<Real>(term.decay), g = static_cast<Real>(term.g),
                rate = static_cast<Real>(term.rate);
    for (int n = 0; n < 6; ++n) {
      const Lanes z = Z != nullptr ? Lanes::load(Z + (i * 6 + n) * 16) : none, q = z + now * S[n];
      if (Z != nullptr) (z + (later * S[n] - decay * z)).store(Z + (i * 6 + n) * 16);
      Q[n] += q;
      flow[n] += rate * (g * S[n] - q);
    }
  }
  const auto withC = [&C](const Lanes(&A)[6]) {
    return (C[0] * A[0] + C[1] * A[1] + C[2] * A[2]) + Real(2) * (C[3] * A[3] + C[4] * A[4] + C[5] * A[5]);
  };
  const Lanes CQ = withC(Q);
  (Real(0.5) * (CQ - (Q[0] + Q[1] + Q[2]))).store(points.energy);
  (Real(0.5) * (withC(flow) - (flow[0] + flow[1] + flow[2]))).store(points.power);
  constexpr int place[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const Lanes FQ = F[3 * r] * Q[place[0][c]] + F[3 * r + 1] * Q[place[1][c]] + F[3 * r + 2] * Q[place[2][c]];
      (P[3 * r + c] - (y2 * FQ - CQ * third * cof[3 * r + c])).store(points.P[3 * r + c]);
    }
}

}  // namespace PALPATE_KERNEL
}  // namespace palpate

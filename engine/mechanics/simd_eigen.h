#pragma once

#include "mechanics/simd_stress.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

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

  /// Starts from C - I = H + H^T + H^T H of a displacement gradient H, whose eigenvalues are known to a share of
  /// themselves, where those of C would be to a share of 1. Four sweeps leave off-diagonals below float rounding, six
  /// below double.
  explicit SymmetricEigenLanes(const SimdTensors& H) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        a[i][j] = (H[3 * i + j] + H[3 * j + i]) + (H[i] * H[j] + H[3 + i] * H[3 + j] + H[6 + i] * H[6 + j]);
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

}  // namespace PALPATE_KERNEL
}  // namespace palpate

#pragma once

#include "mechanics/materials/isochoric_factor.h"
#include "mechanics/materials/material_law.h"
#include "mechanics/simd_stress.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

///   W = c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + K/2 (J - 1)^2,  K = 2/D1
/// with the invariants I1 = tr C and I2 = (I1^2 - tr C^2) / 2 = |cof F|^2 of C = F^T F. At rest mu = 2 (c10 + c01).
///   dI1/dF = 2 F,  dI2/dF = 2 (I1 F - F C)
/// Tangent along the least stretch l = J / s, whose square is at most J^(2/3):
///   (K + (10 c10 J^(-2/3) I1 + 28 c01 J^(-4/3) I2) / (9 J^2)) s^2 - 2/3 c10 J^(-2/3) - 10/3 c01 J^(-4/3) (I1 - l^2)
/// (Mooney, J. Appl. Phys. 11, 582 (1940); Rivlin, Phil. Trans. A 241, 379 (1948).)
struct MooneyRivlin {
  static constexpr const char *name = "mooney-rivlin", *title = "Mooney-Rivlin", *reference = "";
  static constexpr Parameter parameters[] = {
      {"c10", "C10", Parameter::Type::Number, "Pa", "", atLeast(0),
       "coefficient of the first invariant; the shear modulus at rest is 2 (c10 + c01), not 0."},
      {"c01", "C01", Parameter::Type::Number, "Pa", "", atLeast(0),
       "coefficient of the second invariant; with 0 it is the neo-Hookean law."},
      {"D1", "", Parameter::Type::Number, "1/Pa", "", above(0), "compressibility; the bulk modulus is 2/D1."}};

  static RestModuli restModuli(const Material& m) { return {2 * (m.value[0] + m.value[1]), 2 / m.value[2]}; }

  static std::optional<ParameterProblem> check(const Material& m) {
    if (m.shear_modulus > 0) return {};
    return {{"c10", "\"c10\" and \"c01\" are both 0", "give a shear modulus at rest: 2 (c10 + c01)"}};
  }

  static double shapeEnergy(const Material& m, const Mat3& F) {
    const double J = F.determinant(), I1 = F.squaredNorm(), I2 = cofactor(F).squaredNorm();
    return m.value[0] * (IsochoricFactor(J, -2.0 / 3).value * I1 - 3) +
           m.value[1] * (IsochoricFactor(J, -4.0 / 3).value * I2 - 3);
  }

  static Mat3 firstPiola(const Material& m, const Mat3& F, double pressure) {
    const double c10 = m.value[0], c01 = m.value[1], J = F.determinant(), I1 = F.squaredNorm();
    const Mat3 cof = cofactor(F);
    const IsochoricFactor g1(J, -2.0 / 3), g2(J, -4.0 / 3);
    pressure += c10 * g1.slope * I1 + c01 * g2.slope * cof.squaredNorm();
    return 2 * c10 * g1.value * F + 2 * c01 * g2.value * (I1 * F - F * F.transpose() * F) + pressure * cof;
  }

  template <class Real>
  struct Lanes {
    using Numbers = Simd<Real>;
    using SimdTensors = SimdTensor<Real>;
    Real c10, c01, K;
    BarrierLanes<Real> barrier;
    explicit Lanes(const Material& m)
        : c10(static_cast<Real>(m.value[0])),
          c01(static_cast<Real>(m.value[1])),
          K(static_cast<Real>(m.bulk_modulus)),
          barrier(m) {}

    /// @param patch_pressure  replaces K (J - 1) where the scene averages volume over node patches; or null
    PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Numbers* patch_pressure = nullptr) const {
      SimdTensors F, cof;
      PointStateOf<Real> state;
      const Numbers J = state.J = volumeRatioAndCofactor<Real>(H, F, cof, state.J_minus_1);
      const Numbers I1 = squaredNorm(F), I2 = state.cof2 = squaredNorm(cof);
      // J^(-2/3), J^(-4/3) and their slopes, with the tangents below min_isochoric_J.
      const Numbers Jc = max(J, Numbers(static_cast<Real>(Material::min_isochoric_J)));
      const Numbers y = inverseCubeRoot(Jc);
      Numbers g1 = y * y, g2 = g1 * g1;
      const Numbers slope1 = Numbers(Real(-2) / 3) * g1 / Jc, slope2 = Numbers(Real(-4) / 3) * g2 / Jc;
      g1 += slope1 * (J - Jc);
      g2 += slope2 * (J - Jc);
      Numbers p = patch_pressure ? *patch_pressure : state.J_minus_1 * K;
      state.energy = c10 * (g1 * I1 - Real(3)) + c01 * (g2 * I2 - Real(3)) + Real(0.5) * (p * state.J_minus_1);
      barrier.addTo(p, state.energy, J);
      const Numbers first = g1 * c10, second = g2 * c01;
      state.squeeze = (first * I1 * (Real(10) / 9) + second * I2 * (Real(28) / 9)) / (Jc * Jc) + K;
      state.other = first * (Real(-2) / 3) + second * (I1 - Jc * y) * (Real(-10) / 3);
      barrier.stiffen(state.squeeze, J);
      const Numbers of_FC = g2 * (Real(2) * c01), of_F = g1 * (Real(2) * c10) + of_FC * I1;
      const Numbers of_cof = slope1 * I1 * c10 + slope2 * I2 * c01 + p;
      for (int c = 0; c < 3; ++c) {
        Numbers C[3];  // column c of F^T F
        for (int i = 0; i < 3; ++i) C[i] = F[i] * F[c] + F[3 + i] * F[3 + c] + F[6 + i] * F[6 + c];
        for (int r = 0; r < 9; r += 3)
          P[r + c] = of_F * F[r + c] - of_FC * (F[r] * C[0] + F[r + 1] * C[1] + F[r + 2] * C[2]) + of_cof * cof[r + c];
      }
      return state;
    }
  };
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

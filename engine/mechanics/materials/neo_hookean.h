#pragma once

#include "mechanics/materials/isochoric_factor.h"
#include "mechanics/materials/material_law.h"
#include "mechanics/simd_stress.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

///   W = mu/2 (J^(-2/3) I1 - 3) + K/2 (J - 1)^2,  I1 = tr F^T F,  mu = E / (2 (1 + nu)),  K = E / (3 (1 - 2 nu))
/// Tangent along the least stretch l = J / s:  (K + 5/9 mu J^(-2/3) I1 / J^2) s^2 - 1/3 mu J^(-2/3).
struct NeoHookean {
  static constexpr const char *name = "neo-hookean", *title = "neo-Hookean", *reference = "";
  static constexpr Parameter parameters[] = {
      {"young", "Young's modulus E", Parameter::Type::Number, "Pa", "", aboveUpTo(0, 1e9),
       "Young's modulus at rest. Liver 1000 .. 6000."},
      {"poisson", "Poisson's ratio \xCE\xBD", Parameter::Type::Number, "", "", between(0, 0.4999),
       "Poisson's ratio at rest. 0.49 costs a smaller time step than 0.45, 0.499 a third of that "
       "of 0.49."}};

  static RestModuli restModuli(const Material& m) {
    const double young = m.value[0], poisson = m.value[1];
    return {young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))};
  }

  static std::optional<ParameterProblem> check(const Material&) { return {}; }

  static double shapeEnergy(const Material& m, const Mat3& F) {
    return 0.5 * m.shear_modulus * (IsochoricFactor(F.determinant(), -2.0 / 3).value * F.squaredNorm() - 3);
  }

  static Mat3 firstPiola(const Material& m, const Mat3& F, double pressure) {
    const IsochoricFactor g(F.determinant(), -2.0 / 3);
    return m.shear_modulus * g.value * F + (0.5 * m.shear_modulus * g.slope * F.squaredNorm() + pressure) * cofactor(F);
  }

  template <class Real>
  struct Lanes {
    using Numbers = Simd<Real>;
    using SimdTensors = SimdTensor<Real>;
    Real mu, K;
    BarrierLanes<Real> barrier;
    explicit Lanes(const Material& m)
        : mu(static_cast<Real>(m.shear_modulus)), K(static_cast<Real>(m.bulk_modulus)), barrier(m) {}

    /// @param patch_pressure  replaces K (J - 1) where the scene averages volume over node patches; or null
    PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Numbers* patch_pressure = nullptr) const {
      SimdTensors F, cof;
      PointStateOf<Real> state;
      const Numbers J = state.J = volumeRatioAndCofactor<Real>(H, F, cof, state.J_minus_1);
      const Numbers I1 = squaredNorm(F);
      // g(J) = J^(-2/3) and its slope, with the tangent below min_isochoric_J.
      const Numbers Jc = max(J, Numbers(static_cast<Real>(Material::min_isochoric_J)));
      const Numbers y = inverseCubeRoot(Jc);
      Numbers g = y * y;
      const Numbers slope = Numbers(Real(-2) / 3) * g / Jc;
      g += slope * (J - Jc);
      const Numbers a = g * mu;
      Numbers p = patch_pressure ? *patch_pressure : state.J_minus_1 * K;
      state.energy = Real(0.5) * (mu * (g * I1 - Real(3)) + p * state.J_minus_1);
      barrier.addTo(p, state.energy, J);
      const Numbers b = slope * I1 * (Real(0.5) * mu) + p;
      for (int k = 0; k < 9; ++k) P[k] = a * F[k] + b * cof[k];
      state.cof2 = squaredNorm(cof);
      state.squeeze = a * I1 / (Jc * Jc) * (Real(5) / 9) + K;
      state.other = a * (Real(-1) / 3);
      barrier.stiffen(state.squeeze, J);
      return state;
    }
  };
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

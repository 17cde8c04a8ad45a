#pragma once

#include <cmath>

#include "mechanics/materials/neo_hookean.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

/// One family of fibres in a neo-Hookean matrix: transversely isotropic. With their stretch squared I4 = |F n|^2, n the
/// unit direction at rest, and e = max(I4 - 1, 0), for fibres fold up under compression,
///
///   W = W_neo-Hookean + k1 / (2 k2) (exp(k2 e^2) - 1),   k1/2 e^2 for k2 = 0
///
/// (Holzapfel, Gasser, Ogden, J. Elasticity 61, 1 (2000); k2 = 0: the standard reinforcing model.) I4 is of all of F,
/// not of its isochoric part: else fibres under tension swell a compressible matrix (Helfenstein et al., Int. J. Solids
/// Struct. 47, 2056 (2010)). Stress is continuous at e = 0. From k2 e^2 = 8 on, where a fibre is 50,000 times as stiff
/// as at rest, its tension goes on straight, so that no stretch is beyond a float.
///
/// Tangent: the matrix's, and along the fibre 4 W'' I4 + 2 W', with W' = dW/dI4; 4 k1 at rest under tension.
struct FibreReinforced {
  static constexpr const char *name = "fibre-reinforced", *title = "fibre-reinforced",
                              *reference = "Holzapfel, Gasser, Ogden 2000, one family of fibres";
  static constexpr Parameter parameters[] = {
      NeoHookean::parameters[0],
      NeoHookean::parameters[1],
      {"k1", "k1", Parameter::Type::Number, "Pa", "", atLeast(0),
       "stiffness of the fibres: under tension, at small strain, they add 4 k1 to the matrix's Young's modulus along "
       "them. \"young\" and \"poisson\" are the matrix's. Muscle under passive stretch 1000 .. 20000."},
      {"k2", "k2", Parameter::Type::Number, "", "0", between(0, 1000),
       "how fast they stiffen with their stretch l: as exp(k2 (l^2 - 1)^2)."},
      {"fibre", "fibres along", Parameter::Type::Vector, "", "", anyNumber(),
       "direction of the fibres at rest, in the scene's axes, any length. Without sense: they bear tension alone."}};
  static constexpr int k1_at = 2, k2_at = 3, fibre_at = 4;  // in Material::value
  static constexpr double most_exponent = 8;                // of k2 e^2

  static RestModuli restModuli(const Material& m) {
    RestModuli moduli = NeoHookean::restModuli(m);
    moduli.fibre = 4 * m.value[k1_at];
    moduli.direction = Vec3(m.value[fibre_at], m.value[fibre_at + 1], m.value[fibre_at + 2]).stableNormalized();
    return moduli;
  }

  static std::optional<ParameterProblem> check(const Material& m) {
    if (m.fibre[0] != 0 || m.fibre[1] != 0 || m.fibre[2] != 0) return {};
    return {{"fibre", "\"fibre\" has no length", "give a direction, like [0, 0, 1]"}};
  }

  /// W and its derivatives by I4.
  struct Fibre {
    double energy = 0, slope = 0, tangent = 0;
    Fibre(const Material& m, double I4) {
      const double k1 = m.value[k1_at], k2 = m.value[k2_at], e = I4 - 1;
      if (!(e > 0)) return;
      const double ec = k2 * e * e > most_exponent ? std::sqrt(most_exponent / k2) : e, q = k2 * ec * ec, d = e - ec;
      tangent = k1 * std::exp(q) * (1 + 2 * q);
      slope = k1 * std::exp(q) * ec;
      energy = k1 / 2 * ec * ec * (q > 0 ? std::expm1(q) / q : 1) + d * slope + d * d / 2 * tangent;
      slope += d * tangent;
    }
  };

  static Vec3 direction(const Material& m) { return {m.fibre[0], m.fibre[1], m.fibre[2]}; }

  static double shapeEnergy(const Material& m, const Mat3& F) {
    return NeoHookean::shapeEnergy(m, F) + Fibre(m, (F * direction(m)).squaredNorm()).energy;
  }

  static Mat3 firstPiola(const Material& m, const Mat3& F, double pressure) {
    const Vec3 n = direction(m), Fn = F * n;
    return NeoHookean::firstPiola(m, F, pressure) + 2 * Fibre(m, Fn.squaredNorm()).slope * Fn * n.transpose();
  }

  template <class Real>
  struct Lanes {
    using Numbers = Simd<Real>;
    using SimdTensors = SimdTensor<Real>;
    NeoHookean::Lanes<Real> matrix;
    Real k1, k2, last, n[3];  // `last`: e from which on the tension goes on straight
    explicit Lanes(const Material& m)
        : matrix(m),
          k1(static_cast<Real>(m.value[k1_at])),
          k2(static_cast<Real>(m.value[k2_at])),
          last(static_cast<Real>(m.value[k2_at] > 0 ? std::sqrt(most_exponent / m.value[k2_at]) : 1e6)),
          n{static_cast<Real>(m.fibre[0]), static_cast<Real>(m.fibre[1]), static_cast<Real>(m.fibre[2])} {}

    /// I4 - 1 comes from H without cancellation, so that near rest its rounding is a share of the strain.
    /// @param patch_pressure  replaces K (J - 1) where the scene averages volume over node patches; or null
    PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Numbers* patch_pressure = nullptr) const {
      PointStateOf<Real> state = matrix.firstPiola(H, P, patch_pressure);
      const Numbers none = Real(0), least = static_cast<Real>(1e-30);
      Numbers Hn[3], Fn[3], e = none;
      for (int i = 0; i < 3; ++i) {
        Hn[i] = H[3 * i] * n[0] + H[3 * i + 1] * n[1] + H[3 * i + 2] * n[2];
        Fn[i] = Hn[i] + n[i];
        e += Hn[i] * (Hn[i] + Real(2) * n[i]);
      }
      e = max(e, none);
      const Numbers ec = whereLess(e, Numbers(last), e, Numbers(last)), d = e - ec, q = max(ec * ec * k2, least);
      const Numbers grown = exp2MinusOne(q * static_cast<Real>(1.4426950408889634));  // exp(q) - 1
      Numbers slope = ec * (grown + Real(1)) * k1;
      const Numbers tangent = (grown + Real(1)) * (Real(2) * q + Real(1)) * k1;
      state.energy += ec * ec * (grown / q) * (Real(0.5) * k1) + d * slope + Real(0.5) * d * d * tangent;
      slope += d * tangent;
      state.other += Real(2) * slope + whereLess(none, e, Real(4) * tangent * (e + Real(1)), none);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) P[3 * r + c] += Real(2) * slope * Fn[r] * n[c];
      return state;
    }
  };
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

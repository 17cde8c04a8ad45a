#pragma once

#include <Eigen/Eigenvalues>
#include <cmath>

#include "mechanics/materials/isochoric_factor.h"
#include "mechanics/materials/material_law.h"
#include "mechanics/simd_eigen.h"

namespace palpate {
inline namespace PALPATE_KERNEL {

///   W = sum_k 2 mu_k / a_k^2 (J^(-a_k/3) (l1^a_k + l2^a_k + l3^a_k) - 3) + K/2 (J - 1)^2,  K = 2/D1
/// with the principal stretches l1, l2, l3: paper eq. 32.
/// Tangent along the stretch l_i, with S = sum_j l_j^a_k:
///   K (J / l_i)^2 + sum_k 2 mu_k / a_k^2 J^(-a_k/3) ((a_k^2/9 + a_k/3) S + (a_k^2/3 - a_k) l_i^a_k) / l_i^2
struct Ogden {
  static constexpr const char *name = "ogden", *title = "Ogden", *reference = "paper eq. 32";
  static constexpr Parameter parameters[] = {
      {"mu", "\xCE\xBC", Parameter::Type::Numbers, "Pa", "", anyNumber(),
       "shear moduli, one per term, 1 to 6 terms; their sum is the shear modulus at rest (constants of an energy with "
       "mu/alpha in place of 2 mu/alpha^2 times alpha/2)."},
      {"alpha", "a", Parameter::Type::Numbers, "", "", anyNumber(), "exponents, one per term, not 0."},
      {"D1", "", Parameter::Type::Number, "1/Pa", "", above(0), "compressibility; the bulk modulus is 2/D1."}};
  static constexpr int mu_at = 0, alpha_at = Material::max_terms,
                       D1_at = 2 * Material::max_terms;  // in Material::value

  static RestModuli restModuli(const Material& m) {
    double shear = 0;
    for (int k = 0; k < m.term_count; ++k) shear += m.value[mu_at + k];
    return {shear, 2 / m.value[D1_at]};
  }

  static std::optional<ParameterProblem> check(const Material& m) {
    for (int k = 0; k < m.term_count; ++k)
      if (m.value[alpha_at + k] == 0)
        return {{"alpha", "an exponent is 0", "its energy is not defined: leave the term out"}};
    if (m.shear_modulus > 0) return {};
    return {{"mu", "the shear modulus at rest, the sum of \"mu\", is not positive",
             "check the signs: paper eq. 32 has energy 2 mu / alpha^2 (...)"}};
  }

  struct PrincipalStretches {
    Vec3 squared;
    Mat3 direction;
    explicit PrincipalStretches(const Mat3& F) {
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(F.transpose() * F);
      squared = eigen.eigenvalues().cwiseMax(1e-12);
      direction = eigen.eigenvectors();
    }
  };

  static double shapeEnergy(const Material& m, const Mat3& F) {
    const double J = F.determinant();
    const PrincipalStretches stretch(F);
    double W = 0;
    for (int k = 0; k < m.term_count; ++k) {
      const double mu = m.value[mu_at + k], a = m.value[alpha_at + k];
      const double sum = stretch.squared.array().pow(a / 2).sum();
      W += 2 * mu / (a * a) * (IsochoricFactor(J, -a / 3).value * sum - 3);
    }
    return W;
  }

  static Mat3 firstPiola(const Material& m, const Mat3& F, double pressure) {
    const double J = F.determinant();
    const PrincipalStretches stretch(F);
    Vec3 s = Vec3::Zero();  // coefficients of F n (x) n; `pressure` collects those of cof F
    for (int k = 0; k < m.term_count; ++k) {
      const double mu = m.value[mu_at + k], a = m.value[alpha_at + k];
      const IsochoricFactor g(J, -a / 3);
      const Vec3 power = stretch.squared.array().pow(a / 2);
      s += 2 * mu / a * g.value * power.cwiseQuotient(stretch.squared);
      pressure += 2 * mu / (a * a) * g.slope * power.sum();
    }
    return F * (stretch.direction * s.asDiagonal() * stretch.direction.transpose()) + pressure * cofactor(F);
  }

  template <class Real>
  struct Lanes {
    using Numbers = Simd<Real>;
    using SimdTensors = SimdTensor<Real>;
    int terms;
    Real K;
    Real mu[Material::max_terms], alpha[Material::max_terms];
    BarrierLanes<Real> barrier;
    explicit Lanes(const Material& m) : terms(m.term_count), K(static_cast<Real>(m.bulk_modulus)), barrier(m) {
      for (int k = 0; k < terms; ++k) {
        mu[k] = static_cast<Real>(m.value[mu_at + k]);
        alpha[k] = static_cast<Real>(m.value[alpha_at + k]);
      }
    }

    /// The shape-changing stress as a whole, P = F sum_i t_i / l_i^2 n_i (x) n_i + pressure cof F with
    ///
    ///   t_i = sum_k 2 mu_k / a_k (q_i - (q_1 + q_2 + q_3) / 3),  q_i = (J^(-1/3) l_i)^a_k - 1
    ///
    /// from the eigenvalues l_i^2 - 1 of C - I: near rest its rounding is a share of the strain. As the difference of
    /// two stresses of about mu, it would be a share of mu, and keep tissue at rest from coming to rest.
    /// Below the least J, Jc, with x = J / Jc - 1, J^(-a/3) = Jc^(-a/3) (1 - a x / 3), or Jc^(-a/3) / (1 + a x / 3) for
    /// a < 0, as IsochoricFactor has it; there the two are added up.
    /// @param patch_pressure  replaces K (J - 1) where the scene averages volume over node patches; or null
    PointStateOf<Real> firstPiola(const SimdTensors& H, SimdTensors& P, const Numbers* patch_pressure = nullptr) const {
      SimdTensors F, cof;
      PointStateOf<Real> state;
      const Numbers J = state.J = volumeRatioAndCofactor<Real>(H, F, cof, state.J_minus_1);
      const SymmetricEigenLanes<Real> eigen(H);
      constexpr Real least = static_cast<Real>(Material::min_isochoric_J);
      const Numbers Jc = max(J, Numbers(least)), x = (J - Jc) / Jc;
      const Numbers log_J = log2OnePlus(max(state.J_minus_1, Numbers(least - 1)), Jc) * Real(2.0 / 3);
      Numbers Fn[3][3], squared[3], log_squared[3], t[3];
      for (int i = 0; i < 3; ++i) {
        for (int r = 0; r < 3; ++r)
          Fn[i][r] = F[3 * r] * eigen.v[0][i] + F[3 * r + 1] * eigen.v[1][i] + F[3 * r + 2] * eigen.v[2][i];
        squared[i] =
            max(Fn[i][0] * Fn[i][0] + Fn[i][1] * Fn[i][1] + Fn[i][2] * Fn[i][2], Numbers(static_cast<Real>(1e-12)));
        log_squared[i] = log2OnePlus(eigen.a[i][i], squared[i]) - log_J;  // of J^(-2/3) l_i^2
        t[i] = 0.0F;
      }
      Numbers pressure = patch_pressure ? *patch_pressure : state.J_minus_1 * K;
      state.energy = Real(0.5) * pressure * state.J_minus_1;
      barrier.addTo(pressure, state.energy, J);
      state.cof2 = squaredNorm(cof);
      state.squeeze = K;
      barrier.stiffen(state.squeeze, J);
      Numbers tangent[3];  // times l_i^2
      for (auto& c : tangent) c = Real(0);
      for (int k = 0; k < terms; ++k) {
        const Real al = alpha[k], shear = 2 * mu[k] / al;
        Numbers slope = x * (-al / 3), steepness = Real(1);
        if (al < 0) {
          const Numbers f = Numbers(Real(1)) / (Numbers(Real(1)) - slope);
          slope *= f;
          steepness = f * f;
        }
        Numbers q[3];
        for (int i = 0; i < 3; ++i) q[i] = exp2MinusOne(log_squared[i] * (Real(0.5) * al));
        const Numbers sum = q[0] + q[1] + q[2], mean = sum * static_cast<Real>(1.0 / 3);
        const Numbers none = Real(0), factor = (slope + Real(1)) * shear;
        const Numbers taken = whereLess(x, none, Numbers(Real(-1)), mean);
        for (int i = 0; i < 3; ++i) t[i] += (q[i] - taken) * factor;
        pressure -= whereLess(x, none, (mean + Real(1)) * steepness * shear / Jc, none);
        state.energy += (sum + slope * sum + slope * Real(3)) * (shear / al);
        const Real of_all = shear * (al / 9 + Real(1) / 3), of_own = shear * (al / 3 - 1);
        for (int i = 0; i < 3; ++i) tangent[i] += (sum + Real(3)) * of_all + (q[i] + Real(1)) * of_own;
      }
      state.other = tangent[0] / squared[0];
      for (int i = 1; i < 3; ++i) state.other = max(state.other, tangent[i] / squared[i]);
      for (int i = 0; i < 3; ++i) {
        const Numbers s = t[i] / squared[i];
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            const Numbers term = Fn[i][r] * s * eigen.v[c][i];
            P[3 * r + c] = i == 0 ? term : P[3 * r + c] + term;
          }
      }
      for (int k = 0; k < 9; ++k) P[k] += pressure * cof[k];
      return state;
    }
  };
};

}  // namespace PALPATE_KERNEL
}  // namespace palpate

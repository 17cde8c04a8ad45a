#include "mechanics/materials/material.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>

namespace palpate {
namespace {

Mat3 cofactor(const Mat3& F) {
  Mat3 c;
  c.col(0) = F.col(1).cross(F.col(2));
  c.col(1) = F.col(2).cross(F.col(0));
  c.col(2) = F.col(0).cross(F.col(1));
  return c;
}

/// g(J) = J^e and its derivative; below min_isochoric_J the tangent there, so that energy and
/// stress stay finite and consistent for inverted F.
struct IsochoricFactor {
  double value, slope;
  IsochoricFactor(double J, double e) {
    const double Jc = std::max(J, Material::min_isochoric_J);
    value = std::pow(Jc, e);
    slope = e * value / Jc;
    value += slope * (J - Jc);
  }
};

struct PrincipalStretches {
  Vec3 squared;
  Mat3 direction;
  explicit PrincipalStretches(const Mat3& F) {
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(F.transpose() * F);
    squared = eigen.eigenvalues().cwiseMax(1e-12);
    direction = eigen.eigenvectors();
  }
};

}  // namespace

Material Material::neoHookean(double young, double poisson, double density) {
  Material m;
  m.kind = Kind::NeoHookean;
  m.shear_modulus = young / (2 * (1 + poisson));
  m.bulk_modulus = young / (3 * (1 - 2 * poisson));
  m.density = density;
  return m;
}

Material Material::ogden(const double* mu, const double* alpha, int term_count, double D1, double density) {
  if (term_count < 1 || term_count > max_terms) throw std::invalid_argument("Ogden material: 1 to 6 terms");
  Material m;
  m.kind = Kind::Ogden;
  m.term_count = term_count;
  for (int k = 0; k < term_count; ++k) {
    m.mu[k] = mu[k];
    m.alpha[k] = alpha[k];
    m.shear_modulus += mu[k];
  }
  m.bulk_modulus = 2 / D1;
  m.density = density;
  return m;
}

double Material::barrierPressure(double J) const {
  if (barrier_strength == 0 || J >= barrier_J0) return 0;
  const double Jc = std::max(J, min_isochoric_J);
  return bulk_modulus * barrier_strength * (std::log(Jc / barrier_J0) + (J - Jc) / Jc);
}

double Material::energy(const Mat3& F) const {
  const double J = F.determinant();
  double W = 0.5 * bulk_modulus * (J - 1) * (J - 1);
  if (barrier_strength > 0 && J < barrier_J0) {
    const double Jc = std::max(J, min_isochoric_J), d = J - Jc;
    W += bulk_modulus * barrier_strength *
         (Jc * std::log(Jc / barrier_J0) - Jc + barrier_J0 + d * std::log(Jc / barrier_J0) + d * d / (2 * Jc));
  }
  if (kind == Kind::NeoHookean)
    return W + 0.5 * shear_modulus * (IsochoricFactor(J, -2.0 / 3).value * F.squaredNorm() - 3);
  const PrincipalStretches stretch(F);
  for (int k = 0; k < term_count; ++k) {
    const double a = alpha[k];
    const double sum = stretch.squared.array().pow(a / 2).sum();
    W += 2 * mu[k] / (a * a) * (IsochoricFactor(J, -a / 3).value * sum - 3);
  }
  return W;
}

Mat3 Material::firstPiola(const Mat3& F) const { return firstPiola(F, bulk_modulus * (F.determinant() - 1)); }

Mat3 Material::firstPiola(const Mat3& F, double pressure) const {
  const double J = F.determinant();
  const Mat3 cof = cofactor(F);  // dJ/dF
  pressure += barrierPressure(J);
  if (kind == Kind::NeoHookean) {
    const IsochoricFactor g(J, -2.0 / 3);
    return shear_modulus * g.value * F + (0.5 * shear_modulus * g.slope * F.squaredNorm() + pressure) * cof;
  }
  const PrincipalStretches stretch(F);
  Vec3 s = Vec3::Zero();  // coefficients of F n (x) n; `pressure` collects those of cof F
  for (int k = 0; k < term_count; ++k) {
    const double a = alpha[k];
    const IsochoricFactor g(J, -a / 3);
    const Vec3 power = stretch.squared.array().pow(a / 2);
    s += 2 * mu[k] / a * g.value * power.cwiseQuotient(stretch.squared);
    pressure += 2 * mu[k] / (a * a) * g.slope * power.sum();
  }
  return F * (stretch.direction * s.asDiagonal() * stretch.direction.transpose()) + pressure * cof;
}

double vonMises(const Mat3& P, const Mat3& F) {
  const Mat3 cauchy = P * F.transpose() / F.determinant();
  const Mat3 deviator = cauchy - cauchy.trace() / 3 * Mat3::Identity();
  return std::sqrt(1.5) * deviator.norm();
}

}  // namespace palpate

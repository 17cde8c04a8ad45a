#include "approximation/mmls.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "approximation/weight_function.h"

namespace palpate {
namespace {

/// Below this reciprocal condition the solution of the moment equations has no correct digit left
/// in the linear part; MMLS with mu of 1e-2..1 sits at 1e-6..1e-2 for healthy supports.
constexpr double singular_reciprocal_condition = 1e-13;
/// Smallest over largest pivot. Above it the condition need not be estimated, which takes as long as five solutions:
/// with L's entries below 1 and 2.6e7 >= (n 2^(n-1))^2 for n = 10, it is above the bound.
constexpr double healthy_pivots = 1e-5;

template <int Dim>
constexpr int linear_size = 1 + Dim;
template <int Dim>
constexpr int quadratic_size = 1 + Dim + Dim*(Dim + 1) / 2;

/// Monomials of xi: 1, xi_k, then xi_k^2, then xi_k xi_l (k < l).
template <int Dim, int Size, class Vec>
void monomials(const Vec& xi, double* p) {
  p[0] = 1;
  for (int k = 0; k < Dim; ++k) p[1 + k] = xi[k];
  if constexpr (Size > linear_size<Dim>) {
    int m = linear_size<Dim>;
    for (int k = 0; k < Dim; ++k) p[m++] = xi[k] * xi[k];
    for (int k = 0; k < Dim; ++k)
      for (int l = k + 1; l < Dim; ++l) p[m++] = xi[k] * xi[l];
  }
}

}  // namespace

template <int Dim>
bool Mmls<Dim>::evaluate(const Vec& x, const Vec* X, const double* radius, int count, const std::uint8_t* pinned,
                         bool gradients) {
  N_.resize(count);
  w_.resize(count);
  gradN_.resize(count);
  dw_.resize(count);
  gp_.resize(count);
  p_.resize(static_cast<std::size_t>(count) * quadratic_size<Dim>);
  return degree_ == 1 ? solve<linear_size<Dim>>(x, X, radius, count, pinned, gradients)
                      : solve<quadratic_size<Dim>>(x, X, radius, count, pinned, gradients);
}

template <int Dim>
template <int Size>
bool Mmls<Dim>::solve(const Vec& x, const Vec* X, const double* radius, int count, const std::uint8_t* pinned,
                      bool gradients) {
  using Basis = Eigen::Matrix<double, Size, 1>;
  using Moment = Eigen::Matrix<double, Size, Size>;

  quality_ = {};
  if (count <= Dim) return false;

  // Weights, their gradients, and the scale R(x) = sum w_j R_j / sum w_j.
  double sum_w = 0, sum_wR = 0;
  Vec sum_dw = Vec::Zero(), sum_dwR = Vec::Zero();
  for (int j = 0; j < count; ++j) {
    const Vec d = x - X[j];
    const double s = d.norm() / radius[j];
    w_[j] = quarticSpline(s);
    double slope = quarticSplineSlope(s);
    if (pinned != nullptr && pinned[j] != 0) {
      slope = slope * pinnedFactor(s) + w_[j] * pinnedSlope(s);
      w_[j] *= pinnedFactor(s);
    }
    dw_[j] = slope / (radius[j] * radius[j]) * d;
    sum_w += w_[j];
    sum_wR += w_[j] * radius[j];
    sum_dw += dw_[j];
    sum_dwR += dw_[j] * radius[j];
  }
  if (!(sum_w > 0)) return false;
  const double scale = sum_wR / sum_w;
  const Vec dscale = (sum_dwR - scale * sum_dw) / sum_w;

  // Moment matrix M = P^T W P + H (eq. 4); its lower half is all that the factorization reads.
  Moment M = Moment::Zero();
  for (int j = 0; j < count; ++j) {
    double* p = &p_[static_cast<std::size_t>(j) * Size];
    monomials<Dim, Size>(Vec((X[j] - x) / scale), p);
    for (int b = 0; b < Size; ++b) {
      const double wp = w_[j] * p[b];
      for (int a = b; a < Size; ++a) M(a, b) += wp * p[a];
    }
  }
  for (int m = linear_size<Dim>; m < Size; ++m) M(m, m) += mu_[m - linear_size<Dim>];

  const Eigen::LDLT<Moment> factor(M);
  if (factor.info() != Eigen::Success) return false;
  // The estimate of the condition passes over pivots that are zero. No pivot is below the lowest eigenvalue, none above
  // the highest: this turns away nothing that the estimate should not.
  const auto pivots = factor.vectorD();
  const double lowest = pivots.minCoeff(), highest = pivots.maxCoeff();
  if (!(lowest > singular_reciprocal_condition * highest) || !factor.isPositive()) return false;
  if (!(lowest > healthy_pivots * highest) && !(factor.rcond() > singular_reciprocal_condition)) return false;

  // p(x) = (1, 0, .., 0) in the shifted basis and dp/dx_k = e_k / scale, so with g = M^-1 p(x)
  //   N_j       = w_j g . p_j
  //   dN_j/dx_k = dw_j/dx_k g . p_j + w_j (M^-1 (e_k / scale - dM_k g)) . p_j
  //   dM_k g    = sum_j dw_j/dx_k (g . p_j) p_j + dH_k g
  // H in the unscaled basis is mu R(x)^4, so relative to the scale at x it is mu, with derivative 4 mu (dR/dx) / R.
  const Basis g = factor.solve(Basis::Unit(0));
  if (!gradients) {
    double sum_N = 0;
    Vec sum_Nxi = Vec::Zero();
    for (int j = 0; j < count; ++j) {
      N_[j] = w_[j] * g.dot(Eigen::Map<const Basis>(&p_[static_cast<std::size_t>(j) * Size]));
      sum_N += N_[j];
      quality_.magnitude += std::abs(N_[j]);
      sum_Nxi += N_[j] * ((X[j] - x) / scale);
    }
    quality_.linear_error = std::max(std::abs(sum_N - 1), sum_Nxi.cwiseAbs().maxCoeff());
    return std::isfinite(quality_.linear_error);
  }
  Eigen::Matrix<double, Size, Dim> dMg = Eigen::Matrix<double, Size, Dim>::Zero();
  for (int j = 0; j < count; ++j) {
    const Eigen::Map<const Basis> pj(&p_[static_cast<std::size_t>(j) * Size]);
    gp_[j] = g.dot(pj);
    for (int k = 0; k < Dim; ++k) dMg.col(k) += dw_[j][k] * gp_[j] * pj;
  }
  for (int m = linear_size<Dim>; m < Size; ++m)
    for (int k = 0; k < Dim; ++k) dMg(m, k) += 4 * mu_[m - linear_size<Dim>] * dscale[k] / scale * g[m];
  Basis h[Dim];
  for (int k = 0; k < Dim; ++k) h[k] = factor.solve(Basis(Basis::Unit(1 + k) / scale - dMg.col(k)));

  double sum_N = 0;
  Vec sum_Nxi = Vec::Zero(), sum_grad = Vec::Zero();
  Eigen::Matrix<double, Dim, Dim> sum_gradx = Eigen::Matrix<double, Dim, Dim>::Zero();
  for (int j = 0; j < count; ++j) {
    const Eigen::Map<const Basis> pj(&p_[static_cast<std::size_t>(j) * Size]);
    N_[j] = w_[j] * gp_[j];
    for (int k = 0; k < Dim; ++k) gradN_[j][k] = dw_[j][k] * gp_[j] + w_[j] * h[k].dot(pj);

    const Vec xi = (X[j] - x) / scale;
    sum_N += N_[j];
    quality_.magnitude += std::abs(N_[j]);
    sum_Nxi += N_[j] * xi;
    sum_grad += gradN_[j] * scale;
    sum_gradx += gradN_[j] * xi.transpose() * scale;
    quality_.gradient_norm = std::max(quality_.gradient_norm, gradN_[j].norm() * scale);
  }
  quality_.linear_error = std::max(std::abs(sum_N - 1), sum_Nxi.cwiseAbs().maxCoeff());
  quality_.gradient_error = std::max(sum_grad.cwiseAbs().maxCoeff(),
                                     (sum_gradx - Eigen::Matrix<double, Dim, Dim>::Identity()).cwiseAbs().maxCoeff());
  return std::isfinite(quality_.linear_error + quality_.gradient_error);
}

template class Mmls<2>;
template class Mmls<3>;

}  // namespace palpate

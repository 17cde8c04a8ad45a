#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace palpate {

/// How well a support carries the approximation at one point.
struct MmlsQuality {
  double linear_error = 0;    // largest error in reproducing 1 and x / scale by N
  double magnitude = 0;       // sum_j |N_j|, the Lebesgue function: by how much errors at the nodes may grow
  double gradient_error = 0;  // largest error in reproducing their gradients by gradN; 0 where it is not wanted
  double gradient_norm = 0;   // max_j |gradN_j| * scale; likewise
};

/// Options of the modified moving least squares approximation.
struct MmlsOptions {
  int degree = 2;   // of the basis: 1 or 2
  double mu = 0.2;  // weight of the constraints on second-degree coefficients, dimensionless:
                    // in the basis of (x - X_j) / R. 0 gives classical moving least squares.
  /// One weight per constraint instead of mu, in the order of the monomials: mu_xx, mu_yy, mu_zz, mu_xy,
  /// mu_xz, mu_yz (in 2D mu_xx, mu_yy, mu_xy, and the rest is not read). >= 0.
  std::optional<std::array<double, 6>> mu_each = std::nullopt;
};

/// Modified moving least squares shape functions at one point (paper eqs. 1-7) in Dim = 2 or 3
/// dimensions, with exact first derivatives.
///
///   N_j(x) = p(x)^T (P^T W P + H)^-1 p(X_j) w_j(x),   H = diag(0, .., 0, mu_xx, mu_yy, ..)
///
/// The basis is shifted to x and scaled by the weighted mean radius R(x) of the support: the
/// second-degree coefficients do not change under the shift, and the scale makes mu dimensionless.
/// The variation of R(x) is part of the derivative.
///
/// Reusable scratch: one object per thread; no allocation once the largest support was seen.
template <int Dim>
class Mmls {
 public:
  using Vec = Eigen::Matrix<double, Dim, 1>;

  explicit Mmls(const MmlsOptions& options) : degree_(options.degree) {
    mu_.fill(options.mu);
    if (options.mu_each) mu_ = *options.mu_each;
  }

  /// Evaluates N and gradN at x for a support of `count` nodes.
  /// @param X       node positions, m                       (count)
  /// @param radius  support radii R_j, m, > |x - X_j|        (count)
  /// @param pinned  not 0 at nodes that the approximation goes through (weight_function.h); null: none (count)
  /// @param gradients  false: gradN is not wanted, and left undefined; N has the same bits, at half the cost
  /// @return false if the moment matrix is numerically singular; N and gradN are then undefined.
  bool evaluate(const Vec& x, const Vec* X, const double* radius, int count, const std::uint8_t* pinned = nullptr,
                bool gradients = true);

  const std::vector<double>& N() const { return N_; }       // (count)
  const std::vector<Vec>& gradN() const { return gradN_; }  // (count) 1/m
  const MmlsQuality& quality() const { return quality_; }

 private:
  template <int Size>
  bool solve(const Vec& x, const Vec* X, const double* radius, int count, const std::uint8_t* pinned, bool gradients);

  int degree_;
  std::array<double, 6> mu_;  // weights of the constraints
  std::vector<double> N_, w_, gp_;
  std::vector<Vec> gradN_, dw_;
  std::vector<double> p_;  // (count * Size)
  MmlsQuality quality_;
};

extern template class Mmls<2>;
extern template class Mmls<3>;

}  // namespace palpate

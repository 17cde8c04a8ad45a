#include "approximation/mmls_value.h"

#include <algorithm>
#include <cmath>

#include "approximation/shape_functions.h"
#include "approximation/weight_function.h"

namespace palpate {
namespace {

constexpr int linear_terms = 4;  // 1, x, y, z

/// g = M^-1 (1, 0, .., 0) by M = L D L^T, of which the lower half is read and overwritten, column by column.
/// @return false where a pivot is not positive, or so small that no digit would be right
template <int Size, int Padded>
bool firstColumnOfInverse(double (&M)[Size][Padded], double (&g)[Size]) {
  constexpr double singular = 1e-13;  // of the largest pivot
  double D[Size], largest = 0;
  for (int k = 0; k < Size; ++k) {
    D[k] = M[k][k];
    largest = std::max(largest, D[k]);
    if (!(D[k] > singular * largest)) return false;
    for (int c = k + 1; c < Size; ++c) {
      const double factor = M[k][c] / D[k];
      for (int r = c; r < Size; ++r) M[c][r] -= factor * M[k][r];
    }
  }
  // Column k of M now is that of L D. L y = e_0, D z = y, L^T g = z.
  double y[Size] = {1};
  for (int r = 1; r < Size; ++r) y[r] = 0;
  for (int k = 0; k < Size; ++k) {
    y[k] /= D[k];
    for (int r = k + 1; r < Size; ++r) y[r] -= M[k][r] * y[k];
  }
  for (int k = Size - 1; k >= 0; --k) {
    double sum = 0;
    for (int r = k + 1; r < Size; ++r) sum += M[k][r] * g[r];
    g[k] = y[k] - sum / D[k];
  }
  return true;
}

}  // namespace

template <int Size>
bool MmlsValue::solve(const Vec3& x, const std::vector<Node>& support, Vec3& u) {
  constexpr int padded = (Size + 3) / 4 * 4;  // whole columns are quicker than their lower halves
  const std::size_t count = support.size();
  w_.resize(count);
  p_.resize(count * padded);
  double sum_w = 0, sum_wR = 0;
  for (std::size_t j = 0; j < count; ++j) {
    w_[j] = quarticSpline((x - support[j].X).norm() / support[j].radius);
    sum_w += w_[j];
    sum_wR += w_[j] * support[j].radius;
  }
  if (!(sum_w > 0)) return false;
  const double per_scale = sum_w / sum_wR;
  double M[Size][padded] = {};
  for (std::size_t j = 0; j < count; ++j) {
    const Vec3 xi = per_scale * (support[j].X - x);
    double* p = &p_[j * padded];
    std::fill_n(p, padded, 0.0);
    p[0] = 1;
    for (int k = 0; k < 3; ++k) p[1 + k] = xi[k];
    if constexpr (Size > linear_terms) {
      for (int k = 0; k < 3; ++k) p[4 + k] = xi[k] * xi[k];
      p[7] = xi[0] * xi[1];
      p[8] = xi[0] * xi[2];
      p[9] = xi[1] * xi[2];
    }
    for (int b = 0; b < Size; ++b) {
      const double wp = w_[j] * p[b];
      for (int a = 0; a < padded; ++a) M[b][a] += wp * p[a];
    }
  }
  for (int m = linear_terms; m < Size; ++m)
    M[m][m] += options_.mu_each ? (*options_.mu_each)[static_cast<std::size_t>(m - linear_terms)] : options_.mu;
  double g[Size];
  if (!firstColumnOfInverse(M, g)) return false;
  double sum_N = 0;
  Vec3 sum_Nxi = Vec3::Zero();
  u.setZero();
  for (std::size_t j = 0; j < count; ++j) {
    const double* p = &p_[j * padded];
    double N = 0;
    for (int a = 0; a < Size; ++a) N += g[a] * p[a];
    N *= w_[j];
    sum_N += N;
    sum_Nxi += N * Vec3(p[1], p[2], p[3]);
    u += N * support[j].u;
  }
  const double error = std::max(std::abs(sum_N - 1), sum_Nxi.cwiseAbs().maxCoeff());
  return error <= AdmissibilityLimits{}.linear_error;
}

bool MmlsValue::at(const Vec3& x, const std::vector<Node>& support, Vec3& u) {
  if (support.size() < linear_terms) return false;
  return options_.degree == 1 ? solve<linear_terms>(x, support, u) : solve<10>(x, support, u);
}

}  // namespace palpate

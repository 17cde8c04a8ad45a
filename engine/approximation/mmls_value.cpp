#include "approximation/mmls_value.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "approximation/shape_functions.h"

namespace palpate {
namespace {

constexpr int linear_terms = 4;  // 1, x, y, z

/// g = M^-1 (1, 0, .., 0) by M = L D L^T, of which the lower half is read and overwritten, column by column.
/// @return false where a pivot is not positive, or so small that no digit would be right
template <int Size>
bool firstColumnOfInverse(double (&M)[Size][Size], double (&g)[Size]) {
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

namespace {

constexpr int pack_width = 4;  // nodes at a time
using Pack = Eigen::Array<double, pack_width, 1>;

/// The products of powers of x, y, z up to the fourth degree, each made of a lower one by one factor: all products of
/// two terms of a basis of the second degree. So 35 sums over the nodes are all that the moment matrix needs.
struct Monomials {
  std::array<int, 35> lower{}, axis{};               // of which monomial it is made, by which factor
  std::array<std::array<int, 10>, 10> of_product{};  // of two terms of the basis

  constexpr Monomials() {
    std::array<std::array<int, 3>, 35> power{};
    int count = 1;
    for (int degree = 1, first = 0; degree <= 4; ++degree) {
      const int last = count;
      for (int m = first; m < last; ++m)
        for (int a = lastAxis(power[m]); a < 3; ++a) {  // in ascending order of axes, so that none is made twice
          power[count] = power[m];
          ++power[count][a];
          lower[count] = m;
          axis[count++] = a;
        }
      first = last;
    }
    constexpr int basis[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                  {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
    for (int a = 0; a < 10; ++a)
      for (int b = 0; b < 10; ++b)
        for (int m = 0; m < 35; ++m)
          if (power[m][0] == basis[a][0] + basis[b][0] && power[m][1] == basis[a][1] + basis[b][1] &&
              power[m][2] == basis[a][2] + basis[b][2])
            of_product[a][b] = m;
  }

 private:
  static constexpr int lastAxis(const std::array<int, 3>& power) { return power[2] > 0 ? 2 : power[1] > 0 ? 1 : 0; }
};
constexpr Monomials products;

}  // namespace

/// Nodes in packs: place, weight and u of each; those that fill up the last one weigh nothing.
struct MmlsValue::Packed {
  Pack xi[3], w, radius, u[3];
};

MmlsValue::MmlsValue(const MmlsOptions& options) : options_(options) {}
MmlsValue::~MmlsValue() = default;

template <int Size>
bool MmlsValue::solve(const Vec3& x, const std::vector<Node>& support, Vec3& u) {
  const std::size_t count = support.size();
  pack_.resize((count + pack_width - 1) / pack_width);
  for (std::size_t j = 0; j < pack_.size() * pack_width; ++j) {
    Packed& p = pack_[j / pack_width];
    const auto lane = static_cast<Eigen::Index>(j % pack_width);
    const Node& node = support[std::min(j, count - 1)];
    for (int k = 0; k < 3; ++k) {
      p.xi[k][lane] = node.X[k] - x[k];
      p.u[k][lane] = node.u[k];
    }
    p.radius[lane] = node.radius;
  }
  Pack sum_w = Pack::Zero(), sum_wR = Pack::Zero();
  for (std::size_t n = 0; n < pack_.size(); ++n) {
    Packed& p = pack_[n];
    const Pack s = ((p.xi[0].square() + p.xi[1].square() + p.xi[2].square()).sqrt() / p.radius).min(1.0);
    p.w = 1 + s.square() * (-6 + s * (8 - 3 * s));  // quarticSpline
    for (std::size_t j = count; n + 1 == pack_.size() && j < pack_.size() * pack_width; ++j)
      p.w[static_cast<Eigen::Index>(j % pack_width)] = 0;
    sum_w += p.w;
    sum_wR += p.w * p.radius;
  }
  if (!(sum_w.sum() > 0)) return false;
  const double per_scale = sum_w.sum() / sum_wR.sum();
  constexpr int moment_count = Size > linear_terms ? 35 : 10;
  Pack moment[moment_count];
  for (Pack& m : moment) m.setZero();
  for (Packed& p : pack_) {
    for (Pack& xi : p.xi) xi *= per_scale;
    Pack value[moment_count];
    value[0] = p.w;
    moment[0] += p.w;
    for (int m = 1; m < moment_count; ++m) {
      value[m] = value[products.lower[m]] * p.xi[products.axis[m]];
      moment[m] += value[m];
    }
  }
  double sum[moment_count], M[Size][Size];
  for (int m = 0; m < moment_count; ++m) sum[m] = moment[m].sum();
  for (int b = 0; b < Size; ++b)
    for (int a = 0; a < Size; ++a) M[b][a] = sum[products.of_product[a][b]];
  for (int m = linear_terms; m < Size; ++m)
    M[m][m] += options_.mu_each ? (*options_.mu_each)[static_cast<std::size_t>(m - linear_terms)] : options_.mu;
  double g[Size];
  if (!firstColumnOfInverse(M, g)) return false;
  Pack sum_N = Pack::Zero(), magnitude = sum_N, sum_Nxi[3] = {sum_N, sum_N, sum_N}, value[3] = {sum_N, sum_N, sum_N};
  for (const Packed& p : pack_) {
    const auto& [X, Y, Z] = p.xi;
    Pack N = g[0] + g[1] * X + g[2] * Y + g[3] * Z;
    if constexpr (Size > linear_terms)
      N += (g[4] * X + g[7] * Y + g[8] * Z) * X + (g[5] * Y + g[9] * Z) * Y + g[6] * Z.square();
    N *= p.w;
    sum_N += N;
    magnitude += N.abs();
    for (int k = 0; k < 3; ++k) {
      sum_Nxi[k] += N * p.xi[k];
      value[k] += N * p.u[k];
    }
  }
  double error = std::abs(sum_N.sum() - 1);
  for (int k = 0; k < 3; ++k) {
    error = std::max(error, std::abs(sum_Nxi[k].sum()));
    u[k] = value[k].sum();
  }
  constexpr AdmissibilityLimits limits;
  return error <= limits.linear_error && magnitude.sum() <= limits.magnitude;
}

bool MmlsValue::at(const Vec3& x, const std::vector<Node>& support, Vec3& u) {
  if (support.size() < linear_terms) return false;
  return options_.degree == 1 ? solve<linear_terms>(x, support, u) : solve<10>(x, support, u);
}

}  // namespace palpate

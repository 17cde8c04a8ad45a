#include "mtled/matrix/follow.h"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

namespace palpate::tools {
namespace {

/// Of a tangent with entries beside the diagonal only, by elimination from the top: it is that of an energy.
Eigen::VectorXd solvedByRows(Eigen::MatrixXd tangent, Eigen::VectorXd r) {
  const Eigen::Index size = r.size();
  for (Eigen::Index k = 1; k < size; ++k) {
    const double share = tangent(k, k - 1) / tangent(k - 1, k - 1);
    tangent(k, k) -= share * tangent(k - 1, k);
    r[k] -= share * r[k - 1];
  }
  for (Eigen::Index k = size - 1; k >= 0; --k)
    r[k] = (r[k] - (k + 1 < size ? tangent(k, k + 1) * r[k + 1] : 0)) / tangent(k, k);
  return r;
}

Eigen::VectorXd solved(const Eigen::MatrixXd& tangent, const Eigen::VectorXd& r, Eigen::Index band) {
  return band == 1 && r.size() > 3 ? solvedByRows(tangent, r) : Eigen::VectorXd(tangent.partialPivLu().solve(r));
}

}  // namespace

Eigen::VectorXd follow(const Residual& residual, Eigen::Index size, double scale, Eigen::Index band) {
  constexpr int loads = 24, iterations = 30;
  constexpr double accuracy = 1e-9;  // of the scale, Newton's last step: what is left is far less
  const double reach = 1e-6 * scale;
  const Eigen::Index colours = std::min(size, 2 * band + 1);  // columns so far apart share a difference
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size);
  for (int k = 1; k <= loads; ++k) {
    const double load = static_cast<double>(k) / loads;
    bool found = false;
    for (int n = 0; n < iterations && !found; ++n) {
      const Eigen::VectorXd r = residual(x, load);
      Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(size, size);
      for (Eigen::Index colour = 0; colour < colours; ++colour) {
        Eigen::VectorXd more = x, less = x;
        for (Eigen::Index j = colour; j < size; j += colours) {
          more[j] += reach;
          less[j] -= reach;
        }
        const Eigen::VectorXd slope = (residual(more, load) - residual(less, load)) / (2 * reach);
        for (Eigen::Index j = colour; j < size; j += colours)
          for (Eigen::Index i = std::max<Eigen::Index>(0, j - band); i <= std::min(size - 1, j + band); ++i)
            tangent(i, j) = slope[i];
      }
      const Eigen::VectorXd step = solved(tangent, r, band);
      x -= step;
      if (!x.allFinite()) throw std::runtime_error("the closed form has no equilibrium");
      found = step.cwiseAbs().maxCoeff() < accuracy * scale;
    }
    if (!found) throw std::runtime_error("the closed form has no equilibrium");
  }
  return x;
}

}  // namespace palpate::tools

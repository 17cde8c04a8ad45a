#include "mechanics/lanczos.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdint>
#include <vector>

namespace palpate {

LargestEigenvalue largestEigenvalue(Eigen::Index n,
                                    const std::function<void(const Eigen::VectorXd&, Eigen::VectorXd&)>& apply,
                                    int max_iterations, double tolerance) {
  using Vector = Eigen::VectorXd;
  LargestEigenvalue result;
  Vector v(n), previous = Vector::Zero(n), w(n);
  std::uint64_t random = 0x9e3779b97f4a7c15ull;
  for (double& a : v) {  // all frequencies are in it
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    a = static_cast<double>(random >> 11) / 9007199254740992.0 - 0.5;
  }
  v.normalize();
  std::vector<double> diagonal, off;
  for (int k = 0; k < max_iterations; ++k) {
    apply(v, w);
    diagonal.push_back(v.dot(w));
    w -= diagonal.back() * v;
    if (k > 0) w -= off.back() * previous;
    const double beta = w.norm();
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> tridiagonal;
    const Vector d = Eigen::Map<const Vector>(diagonal.data(), k + 1), o = Eigen::Map<const Vector>(off.data(), k);
    tridiagonal.computeFromTridiagonal(d, o);
    result.value = tridiagonal.eigenvalues()[k];
    result.residual = beta * std::abs(tridiagonal.eigenvectors()(k, k));
    result.iterations = k + 1;
    if (result.residual <= tolerance * result.value || beta == 0) break;
    off.push_back(beta);
    previous = v;
    v = w / beta;
  }
  return result;
}

}  // namespace palpate

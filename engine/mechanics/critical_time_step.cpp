#include "mechanics/critical_time_step.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace palpate {
namespace {

using Vector = Eigen::VectorXd;

/// y = M^-1/2 K M^-1/2 x
void applyOperator(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                   const std::vector<Material>& materials, const NodePatches& patches, const Vector& inverse_root_mass,
                   const Vector& x, Vector& y) {
  std::vector<Mat3> H(shape.rowCount(), Mat3::Zero());
  std::vector<double> pressure(shape.rowCount());
  for (int q = 0; q < shape.rowCount(); ++q) {
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
      const int j = shape.node[e];
      H[q] += inverse_root_mass[j] * x.segment<3>(3 * j) * shape.gradN[e].transpose();
    }
    pressure[q] = H[q].trace() * (patches.empty() ? materials[point_material[q]].bulk_modulus : 1);
  }
  if (!patches.empty()) pressure = patchPressure(patches, volume, pressure);

  y.setZero();
  for (int q = 0; q < shape.rowCount(); ++q) {
    const double mu = materials[point_material[q]].shear_modulus;
    const Mat3 VP = volume[q] * ((pressure[q] - 2.0 / 3 * mu * H[q].trace()) * Mat3::Identity() +
                                 mu * (H[q] + H[q].transpose()));
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) {
      const int j = shape.node[e];
      y.segment<3>(3 * j) += inverse_root_mass[j] * (VP * shape.gradN[e]);
    }
  }
}

double gershgorin(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                  const std::vector<Material>& materials, const std::vector<double>& mass, int& worst) {
  std::vector<double> row(mass.size(), 0.0);
  for (int q = 0; q < shape.rowCount(); ++q) {
    double sum = 0;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) sum += shape.gradN[e].norm();
    const double weight = volume[q] * materials[point_material[q]].waveModulus() * sum;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) row[shape.node[e]] += weight * shape.gradN[e].norm();
  }
  double largest = 0;
  for (std::size_t i = 0; i < row.size(); ++i)
    if (row[i] / mass[i] > largest) {
      largest = row[i] / mass[i];
      worst = static_cast<int>(i);
    }
  return largest;
}

}  // namespace

CriticalTimeStep criticalTimeStep(const ShapeTable& shape, const std::vector<double>& volume,
                                  const std::vector<int>& point_material, const std::vector<Material>& materials,
                                  const std::vector<double>& mass, const NodePatches& patches) {
  CriticalTimeStep result;
  const double bound = gershgorin(shape, volume, point_material, materials, mass, result.worst_node);
  result.dt_proven = 2 / std::sqrt(bound);

  // Lanczos without reorthogonalisation: lost orthogonality only repeats converged Ritz values,
  // which does no harm to the largest.
  constexpr int max_iterations = 60;
  constexpr double tolerance = 1e-3;  // of omega^2; half of it on dt
  const Eigen::Index n = static_cast<Eigen::Index>(mass.size()) * 3;
  Vector inverse_root_mass(static_cast<Eigen::Index>(mass.size()));
  for (std::size_t i = 0; i < mass.size(); ++i) inverse_root_mass[static_cast<Eigen::Index>(i)] = 1 / std::sqrt(mass[i]);
  Vector v(n), previous = Vector::Zero(n), w(n);
  // A start vector with all frequencies in it, the same at every call.
  std::uint64_t random = 0x9e3779b97f4a7c15ull;
  for (double& a : v) {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    a = static_cast<double>(random >> 11) / 9007199254740992.0 - 0.5;
  }
  v.normalize();
  std::vector<double> diagonal, off;
  double largest = 0, residual = 0;
  for (int k = 0; k < max_iterations; ++k) {
    applyOperator(shape, volume, point_material, materials, patches, inverse_root_mass, v, w);
    diagonal.push_back(v.dot(w));
    w -= diagonal.back() * v;
    if (k > 0) w -= off.back() * previous;
    const double beta = w.norm();
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> tridiagonal;
    const Vector d = Eigen::Map<const Vector>(diagonal.data(), k + 1), o = Eigen::Map<const Vector>(off.data(), k);
    tridiagonal.computeFromTridiagonal(d, o);
    largest = tridiagonal.eigenvalues()[k];
    residual = beta * std::abs(tridiagonal.eigenvectors()(k, k));
    result.iterations = k + 1;
    if (residual <= tolerance * largest || beta == 0) break;
    off.push_back(beta);
    previous = v;
    v = w / beta;
  }
  result.dt = 2 / std::sqrt(std::min(largest + residual, bound));
  return result;
}

}  // namespace palpate

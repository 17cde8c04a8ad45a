#include "mechanics/critical_time_step.h"

#include <cmath>

#include "mechanics/lanczos.h"

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

}  // namespace

std::vector<double> gershgorinRows(const ShapeTable& shape, const std::vector<double>& volume,
                                   const std::vector<int>& point_material, const std::vector<Material>& materials,
                                   std::size_t node_count) {
  std::vector<double> row(node_count, 0.0);
  for (int q = 0; q < shape.rowCount(); ++q) {
    double sum = 0;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) sum += shape.gradN[e].norm();
    const double weight = std::abs(volume[q]) * materials[point_material[q]].waveModulus() * sum;
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) row[shape.node[e]] += weight * shape.gradN[e].norm();
  }
  return row;
}

CriticalTimeStep criticalTimeStep(const ShapeTable& shape, const std::vector<double>& volume,
                                  const std::vector<int>& point_material, const std::vector<Material>& materials,
                                  const std::vector<double>& mass, const NodePatches& patches) {
  CriticalTimeStep result;
  const auto rows = gershgorinRows(shape, volume, point_material, materials, mass.size());
  double bound = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] / mass[i] > bound) {
      bound = rows[i] / mass[i];
      result.worst_node = static_cast<int>(i);
    }
  result.dt_proven = 2 / std::sqrt(bound);

  constexpr int max_iterations = 60;
  constexpr double tolerance = 1e-3;  // of omega^2; half of it on dt
  Vector inverse_root_mass(static_cast<Eigen::Index>(mass.size()));
  for (std::size_t i = 0; i < mass.size(); ++i) inverse_root_mass[static_cast<Eigen::Index>(i)] = 1 / std::sqrt(mass[i]);
  const auto largest = largestEigenvalue(
      static_cast<Eigen::Index>(mass.size()) * 3,
      [&](const Vector& x, Vector& y) {
        applyOperator(shape, volume, point_material, materials, patches, inverse_root_mass, x, y);
      },
      max_iterations, tolerance);
  result.iterations = largest.iterations;
  result.dt = 2 / std::sqrt(std::min(largest.value + largest.residual, bound));
  return result;
}

}  // namespace palpate

#include "mechanics/critical_time_step.h"

#include <cmath>

#include "base/parallel_for.h"
#include "mechanics/lanczos.h"

namespace palpate {
namespace {

using Vector = Eigen::VectorXd;

/// Parts of the points, each summed on its own: that there are always as many keeps the bits the same on any number
/// of cores.
constexpr int part_count = 8;

/// M^-1/2 K M^-1/2 of the body at rest, applied on all cores.
class StiffnessAtRest {
 public:
  StiffnessAtRest(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                  const std::vector<Material>& materials, const std::vector<double>& mass, const NodePatches& patches)
      : shape_(shape),
        volume_(volume),
        point_material_(point_material),
        materials_(materials),
        patches_(patches),
        stress_(volume.size()),
        dilatation_(volume.size()),
        u_(mass.size()),
        force_(part_count) {
    for (const double m : mass) inverse_root_mass_.push_back(1 / std::sqrt(m));
  }

  void apply(const Vector& x, Vector& y) {
    const int points = shape_.rowCount();
    for (std::size_t j = 0; j < inverse_root_mass_.size(); ++j)
      u_[j] << inverse_root_mass_[j] * x.segment<3>(3 * static_cast<Eigen::Index>(j)), 0;
    parallelFor(points, [&](int first, int last) {
      for (int q = first; q < last; ++q) {
        Eigen::Vector4d column[3] = {Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero(), Eigen::Vector4d::Zero()};
        for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e)
          for (int c = 0; c < 3; ++c) column[c] += shape_.gradN[e][c] * u_[shape_.node[e]];
        Mat3 H;
        H << column[0].head<3>(), column[1].head<3>(), column[2].head<3>();
        const Material& material = materials_[point_material_[q]];
        dilatation_[q] = H.trace() * (patches_.empty() ? material.bulk_modulus : 1);
        const double mu = material.shear_modulus;
        stress_[q] = mu * (H + H.transpose()) - 2.0 / 3 * mu * H.trace() * Mat3::Identity();
        if (material.fibre_modulus > 0) {
          const Vec3 n(material.fibre[0], material.fibre[1], material.fibre[2]);
          stress_[q] += material.fibre_modulus * n.dot(H * n) * n * n.transpose();
        }
      }
    });
    std::vector<double> averaged;
    if (!patches_.empty()) {
      averaged = patchPressure(patches_, volume_, dilatation_);
      addOwnPressure(patches_, point_material_, materials_, dilatation_, averaged);
    }
    const std::vector<double>& pressure = patches_.empty() ? dilatation_ : averaged;
    parallelFor(
        part_count,
        [&](int first, int last) {
          for (int part = first; part < last; ++part) {
            force_[part].assign(inverse_root_mass_.size(), Eigen::Vector4d::Zero());
            const auto begin = [&](int p) { return static_cast<int>(static_cast<long long>(points) * p / part_count); };
            for (int q = begin(part); q < begin(part + 1); ++q) {
              Eigen::Matrix<double, 4, 3> VP = Eigen::Matrix<double, 4, 3>::Zero();
              VP.topRows<3>() = volume_[q] * (stress_[q] + pressure[q] * Mat3::Identity());
              for (int e = shape_.begin[q]; e < shape_.begin[q + 1]; ++e) {
                const Vec3& g = shape_.gradN[e];
                force_[part][shape_.node[e]] += VP.col(0) * g[0] + VP.col(1) * g[1] + VP.col(2) * g[2];
              }
            }
          }
        },
        1);
    parallelFor(static_cast<int>(inverse_root_mass_.size()), [&](int first, int last) {
      for (int i = first; i < last; ++i) {
        Eigen::Vector4d sum = Eigen::Vector4d::Zero();
        for (const auto& force : force_) sum += force[i];
        y.segment<3>(3 * i) = inverse_root_mass_[i] * sum.head<3>();
      }
    });
  }

 private:
  const ShapeTable& shape_;
  const std::vector<double>& volume_;
  const std::vector<int>& point_material_;
  const std::vector<Material>& materials_;
  const NodePatches& patches_;
  std::vector<double> inverse_root_mass_;  // (node_count)
  std::vector<Mat3> stress_;               // (point_count)
  std::vector<double> dilatation_;         // (point_count) or pressure where pointwise
  // In four lanes, of which the last is 0.
  AlignedVector<Eigen::Vector4d> u_;                   // (node_count)
  std::vector<AlignedVector<Eigen::Vector4d>> force_;  // (part_count)(node_count)
};

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
  StiffnessAtRest operator_at_rest(shape, volume, point_material, materials, mass, patches);
  const auto largest = largestEigenvalue(
      static_cast<Eigen::Index>(mass.size()) * 3, [&](const Vector& x, Vector& y) { operator_at_rest.apply(x, y); },
      max_iterations, tolerance);
  result.iterations = largest.iterations;
  result.dt = 2 / std::sqrt(std::min(largest.value + largest.residual, bound));
  return result;
}

}  // namespace palpate

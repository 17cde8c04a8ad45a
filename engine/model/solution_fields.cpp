#include "model/solution_fields.h"

#include <limits>

#include "mechanics/internal_forces.h"

namespace palpate {
namespace {

/// Takes from a point's stress what has relaxed.
void relax(const Material& material, const PointHistory& history, int q, const Mat3& F, Mat3& P) {
  if (material.relaxation_count == 0) return;
  if (history.empty()) {
    P = relaxedStress(relaxationStep(material, std::numeric_limits<double>::infinity()), F, P).P;
    return;
  }
  const auto first = history.Z.begin() + static_cast<std::ptrdiff_t>(q) * history.term_count;
  std::vector<Mat3> Z(first, first + history.term_count);
  P = relaxedStress(relaxationStep(material, history.h, history.term_count), F, P, Z.data()).P;
}

}  // namespace

std::vector<Mat3> pointStresses(const Model& model, const std::vector<Vec3>& u, std::vector<Mat3>& F,
                                const PointHistory& history, const AlignedVector<float>& friction,
                                const KernelMaterials* in_force) {
  const std::vector<Material>& materials = in_force == nullptr ? model.materials : in_force->materials;
  const int points = model.pointCount();
  F.resize(points);
  std::vector<double> pressure(points);
  for (int q = 0; q < points; ++q) {
    F[q] = deformationGradient(model.point_shape, q, u);
    pressure[q] = F[q].determinant() - 1;
  }
  const std::vector<double> J_minus_1 = pressure;
  NodePatches patches = model.patches;
  if (in_force != nullptr && !patches.empty())
    patches.bulk_modulus.assign(in_force->patch_bulk.begin(), in_force->patch_bulk.end());
  if (model.hasCellVolume()) {
    const CellVolumeSpec spec = model.cellVolume();
    const auto shear = patchShear(patches, model.point_material, materials);
    auto of_node = referenceCellVolume({spec.X, spec.cells, spec.node_count, spec.vertex_shape, patches, spec.imposed},
                                       model.point_volume, pressure, shear, u, friction);
    for (std::size_t a = 0; a < of_node.patch_pressure.size(); ++a)
      of_node.patch_pressure[a] += of_node.cell_pressure[a];
    pressure = pointPressure(patches, of_node.patch_pressure);
  } else if (!patches.empty()) {
    pressure = patchPressure(patches, model.point_volume, pressure);
  } else {
    for (int q = 0; q < points; ++q) pressure[q] *= materials[model.point_material[q]].bulk_modulus;
  }
  addOwnPressure(patches, model.point_material, materials, J_minus_1, pressure);
  std::vector<Mat3> P(points);
  for (int q = 0; q < points; ++q) {
    const Material& material = materials[model.point_material[q]];
    P[q] = material.firstPiola(F[q], pressure[q]);
    relax(material, history, q, F[q], P[q]);
  }
  return P;
}

SolutionFields solutionFields(const Model& model, const std::vector<Vec3>& u, const PointHistory& history,
                              const AlignedVector<float>& friction, const KernelMaterials* in_force) {
  SolutionFields fields;
  for (std::size_t i = 0; i < model.X.size(); ++i)
    fields.displacement.push_back(fieldAt(model.node_shape, i, [&](int j) -> const Vec3& { return u[j]; }));

  std::vector<Mat3> F;
  const auto P = pointStresses(model, u, F, history, friction, in_force);
  std::vector<double> volume(model.cells.size(), 0);
  fields.J.assign(model.cells.size(), 0);
  fields.pressure = fields.von_mises = fields.J;
  for (int q = 0; q < model.pointCount(); ++q) {
    const double V = model.point_volume[q], J = F[q].determinant();
    for (const int cell : {model.point_cell[q], model.point_other_cell.empty() ? -1 : model.point_other_cell[q]}) {
      if (cell < 0) continue;
      volume[cell] += V;
      fields.J[cell] += V * J;
      fields.pressure[cell] -= V * (P[q] * F[q].transpose()).trace() / (3 * J);
      fields.von_mises[cell] += V * vonMises(P[q], F[q]);
    }
  }
  for (std::size_t c = 0; c < volume.size(); ++c)
    for (auto* field : {&fields.J, &fields.pressure, &fields.von_mises}) (*field)[c] /= volume[c];
  return fields;
}

}  // namespace palpate

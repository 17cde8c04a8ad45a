#include "mechanics/internal_forces.h"

#include <algorithm>
#include <limits>

#include "base/float4.h"

namespace palpate {
namespace {

template <class Real>
KernelView<Real> viewOf(const KernelLayoutOf<Real>& layout, const KernelMaterialsOf<Real>& materials,
                        KernelScratchOf<Real>& scratch) {
  KernelView<Real> k{};
  k.node_count = layout.node_count;
  k.blocks = layout.blocks.data();
  k.node = layout.node.data();
  k.short_node = layout.short_node.empty() ? nullptr : layout.short_node.data();
  k.gradN = layout.gradN.data();
  k.rounded_gradN = layout.scale.empty() ? nullptr : layout.rounded_gradN.data();
  k.scale = layout.scale.data();
  k.volume = layout.volume.data();
  k.stress_volume = layout.stress_volume.empty() ? layout.volume.data() : layout.stress_volume.data();
  k.batch_material = layout.batch_material.data();
  k.materials = materials.materials.data();
  k.patch_begin = layout.patch_begin.empty() ? nullptr : layout.patch_begin.data();
  k.patch_point = layout.patch_point.data();
  k.patch_share = layout.patch_share.data();
  k.patch_bulk = materials.patch_bulk.data();
  k.patch_node = layout.patch_node.data();
  k.patch_weight = layout.patch_weight.data();
  k.own_bulk = layout.own_bulk.empty() ? nullptr : layout.own_bulk.data();
  k.chunk_begin = layout.chunk_begin.data();
  k.chunk_node_begin = layout.chunk_node_begin.data();
  k.chunk_node_end = layout.chunk_node_end.data();
  k.chunk_count = static_cast<int>(layout.chunk_node_begin.size());
  k.force = scratch.force.data();
  k.report = scratch.report.data();
  k.displacement_gradient = scratch.displacement_gradient.data();
  k.dilatation = scratch.dilatation.data();
  k.patch_pressure = scratch.patch_pressure.data();
  k.cof2 = scratch.cof2.data();
  k.J = scratch.J.data();
  k.squeeze = scratch.squeeze.data();
  k.other = scratch.other.data();
  return k;
}

template <class Real>
PatchStateOf<Real> patchState(const KernelLayoutOf<Real>& layout, const KernelMaterialsOf<Real>& materials,
                              const KernelView<Real>& k) {
  return {static_cast<int>(layout.batch_material.size()),
          k.patch_node,
          k.patch_begin,
          k.patch_point,
          k.patch_bulk,
          materials.patch_shear.data(),
          k.dilatation,
          k.patch_pressure,
          materials.pressed_dilatation};
}

}  // namespace

template <class Real>
ForceReport internalForces(const KernelLayoutOf<Real>& layout, const KernelMaterialsOf<Real>& materials,
                           const Real4<Real>* u, KernelScratchOf<Real>& scratch, SpinTeam& team,
                           RelaxationHistoryOf<Real>* history, double h) {
  KernelView<Real> k = viewOf(layout, materials, scratch);
  k.relaxation_terms = history != nullptr ? history->term_count : Material::max_relaxation_terms;
  k.relaxation_step = history != nullptr ? h : std::numeric_limits<double>::infinity();
  k.relaxation = history != nullptr ? history->Z.data() : nullptr;
  const KernelPasses<Real>& passes = *scratch.passes;
  ForceReport total;
  if (k.patch_begin) {
    const auto patch_count = static_cast<std::int64_t>(layout.patch_begin.size()) - 1;
    const auto border = [&](int part) { return static_cast<int>(patch_count * part / k.chunk_count); };
    shareOut(team, k.chunk_count, [&](int chunk) { passes.dilatation(k, chunk, u); });
    const PatchStateOf<Real> patches = patchState(layout, materials, k);
    const bool with_cells = !layout.cell_volume.empty();
    shareOut(team, k.chunk_count, [&](int part) {
      passes.sumPatches(k, border(part), border(part + 1));
      if (with_cells) findPressed(patches, part, scratch.cell_volume);
    });
    if (with_cells) {
      const CellReport cells = cellForces(layout.cell_volume, patches, u, scratch.cell_volume, team);
      total.strain_energy = cells.energy;
      total.max_cell_pressure = cells.max_pressure;
    }
  }
  shareOut(team, k.chunk_count, [&](int chunk) { passes.forces(k, chunk, u); });

  for (const auto& r : scratch.report) {
    total.inverted_points += r.inverted;
    total.strain_energy += r.energy;
    total.volume_change += r.volume_change;
    total.relaxed_energy += r.relaxed_energy;
    total.relaxation_power += r.relaxation_power;
    total.max_cof2 = std::max<double>(total.max_cof2, r.max_cof2);
    total.max_squeeze = std::max<double>(total.max_squeeze, r.max_squeeze);
    total.max_modulus = std::max<double>(total.max_modulus, r.max_modulus);
    total.max_patch_pressure = std::max<double>(total.max_patch_pressure, r.max_pressure);
    if (r.min_J < total.min_J) {
      total.min_J = static_cast<float>(r.min_J);
      total.worst_point = layout.point[r.worst_point];
    }
  }
  return total;
}

template <class Real>
void sumForces(const KernelLayoutOf<Real>& layout, const KernelScratchOf<Real>& scratch, int begin, int end,
               Real4<Real>* f) {
  std::fill(f + begin, f + end, Real4<Real>{});
  for (std::size_t c = 0; c < layout.chunk_node_begin.size(); ++c) {
    const Real4<Real>* from = scratch.force.data() + c * static_cast<std::size_t>(layout.node_count);
    for (int i = std::max(begin, layout.chunk_node_begin[c]); i < std::min(end, layout.chunk_node_end[c]); ++i)
      store(f[i], load(f[i]) + load(from[i]));
  }
  if (!layout.cell_volume.empty()) addCellForces(layout.cell_volume, scratch.cell_volume, begin, end, f);
  for (int i = begin; i < end; ++i) f[i].w = 0;  // the kernel leaves the z component there, too
}

template ForceReport internalForces(const KernelLayoutOf<float>&, const KernelMaterialsOf<float>&, const Float4*,
                                    KernelScratchOf<float>&, SpinTeam&, RelaxationHistory*, double);
template ForceReport internalForces(const KernelLayoutOf<double>&, const KernelMaterialsOf<double>&, const Double4*,
                                    KernelScratchOf<double>&, SpinTeam&, RelaxationHistoryOf<double>*, double);
template void sumForces(const KernelLayoutOf<float>&, const KernelScratchOf<float>&, int, int, Float4*);
template void sumForces(const KernelLayoutOf<double>&, const KernelScratchOf<double>&, int, int, Double4*);

Mat3 deformationGradient(const ShapeTable& shape, int row, const std::vector<Vec3>& u) {
  Mat3 F = Mat3::Identity();
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e) F += u[shape.node[e]] * shape.gradN[e].transpose();
  return F;
}

namespace {

/// Pressure of every point: of its node patches, or K (J - 1).
std::vector<double> pressures(const ShapeTable& shape, const std::vector<double>& volume,
                              const std::vector<int>& point_material, const std::vector<Material>& materials,
                              const std::vector<Vec3>& u, const NodePatches& patches) {
  std::vector<double> p;
  p.reserve(volume.size());
  for (int q = 0; q < shape.rowCount(); ++q) p.push_back(deformationGradient(shape, q, u).determinant() - 1);
  if (!patches.empty()) {
    std::vector<double> pressure = patchPressure(patches, volume, p);
    addOwnPressure(patches, point_material, materials, p, pressure);
    return pressure;
  }
  for (int q = 0; q < shape.rowCount(); ++q) p[q] *= materials[point_material[q]].bulk_modulus;
  return p;
}

}  // namespace

void referenceInternalForces(const ShapeTable& shape, const std::vector<double>& volume,
                             const std::vector<int>& point_material, const std::vector<Material>& materials,
                             const std::vector<Vec3>& u, std::vector<Vec3>& f, const NodePatches& patches) {
  const auto pressure = pressures(shape, volume, point_material, materials, u, patches);
  f.assign(u.size(), Vec3::Zero());
  for (int q = 0; q < shape.rowCount(); ++q) {
    const Mat3 PV = volume[q] * materials[point_material[q]].firstPiola(deformationGradient(shape, q, u), pressure[q]);
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) f[shape.node[e]] -= PV * shape.gradN[e];
  }
}

double strainEnergy(const ShapeTable& shape, const std::vector<double>& volume, const std::vector<int>& point_material,
                    const std::vector<Material>& materials, const std::vector<Vec3>& u, const NodePatches& patches) {
  double energy = 0;
  std::vector<double> theta(patches.volume.size(), 0);
  for (int q = 0; q < shape.rowCount(); ++q) {
    const Material& material = materials[point_material[q]];
    const Mat3 F = deformationGradient(shape, q, u);
    const double change = F.determinant() - 1;
    energy += volume[q] * material.energy(F);
    if (patches.empty()) continue;
    const double averaged = patches.own.empty() ? 1 : 1 - patches.own[q];
    energy -= averaged * volume[q] * 0.5 * material.bulk_modulus * change * change;  // the patches' instead
    for (int a = 0; a < 4; ++a)
      theta[patches.node[q][a]] += volume[q] * patches.weight[q][a] / patches.volume[patches.node[q][a]] * change;
  }
  for (std::size_t a = 0; a < theta.size(); ++a)
    energy += 0.5 * patches.volume[a] * patches.bulk_modulus[a] * theta[a] * theta[a];
  return energy;
}

}  // namespace palpate

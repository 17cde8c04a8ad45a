#include "mechanics/internal_forces.h"

#include <algorithm>

#include "base/float4.h"
#include "mechanics/stress_lanes.h"

namespace palpate {
namespace {

/// Tensors of the 16 points of a batch, in memory between the passes over their quads.
template <class Real>
struct alignas(64) BatchTensors {
  Real a[9][16];
};

/// Displacement gradients of a quad's four points, into group `k` of the batch.
/// Lanes of a tile: (node of the group, point of the quad).
template <class Real>
void displacementGradient(const KernelLayoutOf<Real>& layout, const PointQuad& quad, const Real4<Real>* u, int k,
                          BatchTensors<Real>& H) {
  LanesOf<Real> sum[9];
  for (auto& s : sum) s = Real(0);
  const Real* tile = layout.gradN.data() + static_cast<std::size_t>(quad.tile_begin) * 48;
  const std::int32_t* node = layout.node.data() + static_cast<std::size_t>(quad.tile_begin) * 4;
  for (int g = 0; g < quad.group_count; ++g, tile += 48, node += 4) {
    __builtin_prefetch(tile + 512);
    __builtin_prefetch(tile + 528);
    __builtin_prefetch(tile + 544);
    const LanesOf<Real> xyz = LanesOf<Real>::gather(&u[node[0]].x, &u[node[1]].x, &u[node[2]].x, &u[node[3]].x);
    const LanesOf<Real> ux = spread<0>(xyz), uy = spread<1>(xyz), uz = spread<2>(xyz);
    for (int b = 0; b < 3; ++b) {
      const LanesOf<Real> grad = LanesOf<Real>::load(tile + 16 * b);
      sum[b] += ux * grad;
      sum[3 + b] += uy * grad;
      sum[6 + b] += uz * grad;
    }
  }
  for (int c = 0; c < 9; ++c) {
    alignas(64) Real s[16];
    sum[c].store(s);
    storeGroup(H.a[c] + 4 * k, (loadGroup(s) + loadGroup(s + 4)) + (loadGroup(s + 8) + loadGroup(s + 12)));
  }
}

/// Adds -V P gradN of a quad's four points to the forces of its nodes; PV holds V P.
template <class Real>
void scatterForces(const KernelLayoutOf<Real>& layout, const PointQuad& quad, int k, const BatchTensors<Real>& PV, Real4<Real>* f) {
  LanesOf<Real> p[9];
  for (int c = 0; c < 9; ++c) {
    const Real* a = PV.a[c] + 4 * k;
    p[c] = LanesOf<Real>::gather(a, a, a, a);
  }
  const Real* tile = layout.gradN.data() + static_cast<std::size_t>(quad.tile_begin) * 48;
  const std::int32_t* node = layout.node.data() + static_cast<std::size_t>(quad.tile_begin) * 4;
  for (int g = 0; g < quad.group_count; ++g, tile += 48, node += 4) {
    const LanesOf<Real> g0 = LanesOf<Real>::load(tile), g1 = LanesOf<Real>::load(tile + 16), g2 = LanesOf<Real>::load(tile + 32);
    const LanesOf<Real> fx = p[0] * g0 + p[1] * g1 + p[2] * g2;
    const LanesOf<Real> fy = p[3] * g0 + p[4] * g1 + p[5] * g2;
    const LanesOf<Real> fz = p[6] * g0 + p[7] * g1 + p[8] * g2;
    alignas(64) Real sum[16];
    groupSums(fx, fy, fz).store(sum);
    for (int n = 0; n < 4; ++n) {
      Real* fn = &f[node[n]].x;
      storeGroup(fn, loadGroup(fn) - loadGroup(sum + 4 * n));
    }
  }
}

/// Displacement gradients of a batch's 16 points.
template <class Real>
void displacementGradients(const KernelLayoutOf<Real>& layout, int batch, const Real4<Real>* u, BatchTensors<Real>& H) {
  const PointQuad* quads = &layout.quads[static_cast<std::size_t>(batch) * 4];
  for (int k = 0; k < 4; ++k) displacementGradient(layout, quads[k], u, k, H);
}

template <class Real>
TensorLanesOf<Real> loadTensors(const BatchTensors<Real>& tensors) {
  TensorLanesOf<Real> t;
  for (int c = 0; c < 9; ++c) t[c] = LanesOf<Real>::load(tensors.a[c]);
  return t;
}

template <class Real>
void note(const LanesOf<Real>& J, int batch, typename KernelScratchOf<Real>::ChunkReport& report) {
  alignas(64) Real j[16];
  J.store(j);
  int worst = 0;
  for (int i = 0; i < 16; ++i) {
    worst = j[i] < j[worst] ? i : worst;
    report.inverted += j[i] <= 0 ? 1 : 0;
  }
  if (j[worst] < report.min_J) {
    report.min_J = j[worst];
    report.worst_point = batch * 16 + worst;
  }
}

/// Pressure of a batch's points from their nodes' patches: sum_a l_a K_a theta_a.
template <class Real>
LanesOf<Real> patchPressure(const KernelLayoutOf<Real>& layout, int batch, const KernelScratchOf<Real>& scratch) {
  const std::size_t first = static_cast<std::size_t>(batch) * 64;
  alignas(64) Real at_vertex[64];
  for (int i = 0; i < 64; ++i) at_vertex[i] = scratch.patch_pressure[layout.patch_node[first + i]];
  LanesOf<Real> p = Real(0);
  for (int a = 0; a < 4; ++a) p += LanesOf<Real>::load(&layout.patch_weight[first + 16 * a]) * LanesOf<Real>::load(at_vertex + 16 * a);
  return p;
}

/// Stress and forces of a batch from its displacement gradients; `tensors` is overwritten.
template <class MaterialLanes, class Real>
void batchForces(const KernelLayoutOf<Real>& layout, const MaterialLanes& material, int batch, const LanesOf<Real>* patch_pressure,
                 BatchTensors<Real>& tensors, Real4<Real>* f, typename KernelScratchOf<Real>::ChunkReport& report) {
  TensorLanesOf<Real> P;
  note(material.firstPiola(loadTensors(tensors), P, patch_pressure), batch, report);
  const LanesOf<Real> volume = LanesOf<Real>::load(&layout.volume[static_cast<std::size_t>(batch) * 16]);
  for (int c = 0; c < 9; ++c) (P[c] * volume).store(tensors.a[c]);
  const PointQuad* quads = &layout.quads[static_cast<std::size_t>(batch) * 4];
  for (int k = 0; k < 4; ++k) scatterForces(layout, quads[k], k, tensors, f);
}

template <class MaterialLanes, class Real>
void batchesForces(const KernelLayoutOf<Real>& layout, const Material& material, int begin, int end, const Real4<Real>* u,
                   const KernelScratchOf<Real>& scratch, Real4<Real>* f, typename KernelScratchOf<Real>::ChunkReport& report) {
  const MaterialLanes lanes(material);
  BatchTensors<Real> tensors;
  for (int batch = begin; batch < end; ++batch) {
    if (layout.patch_node.empty()) {
      displacementGradients(layout, batch, u, tensors);
      batchForces(layout, lanes, batch, static_cast<const LanesOf<Real>*>(nullptr), tensors, f, report);
    } else {
      std::memcpy(&tensors, &scratch.displacement_gradient[static_cast<std::size_t>(batch) * 144], sizeof tensors);
      const LanesOf<Real> pressure = patchPressure(layout, batch, scratch);
      batchForces(layout, lanes, batch, &pressure, tensors, f, report);
    }
  }
}

/// First pass of the node-patch volume: gradients kept, each point's J - 1 shared out to its nodes' patches.
template <class Real>
void chunkDilatation(const KernelLayoutOf<Real>& layout, int chunk, const Real4<Real>* u, KernelScratchOf<Real>& scratch) {
  Real* theta = scratch.dilatation[chunk].data();
  std::fill(theta + layout.chunk_node_begin[chunk], theta + layout.chunk_node_end[chunk], Real(0));
  BatchTensors<Real> tensors;
  for (int batch = layout.chunk_begin[chunk]; batch < layout.chunk_begin[chunk + 1]; ++batch) {
    displacementGradients(layout, batch, u, tensors);
    std::memcpy(&scratch.displacement_gradient[static_cast<std::size_t>(batch) * 144], &tensors, sizeof tensors);
    const LanesOf<Real> J_minus_1 = volumeChange<Real>(loadTensors(tensors));
    const std::size_t first = static_cast<std::size_t>(batch) * 64;
    alignas(64) Real share[64];
    for (int a = 0; a < 4; ++a) (LanesOf<Real>::load(&layout.patch_share[first + 16 * a]) * J_minus_1).store(share + 16 * a);
    for (int i = 0; i < 64; ++i) theta[layout.patch_node[first + i]] += share[i];
  }
}

/// K_a theta_a of nodes [begin, end), the chunks' shares added in chunk order.
template <class Real>
void sumPatches(const KernelLayoutOf<Real>& layout, int begin, int end, KernelScratchOf<Real>& scratch) {
  std::fill(scratch.patch_pressure.begin() + begin, scratch.patch_pressure.begin() + end, Real(0));
  for (std::size_t c = 0; c < scratch.dilatation.size(); ++c)
    for (int i = std::max(begin, layout.chunk_node_begin[c]); i < std::min(end, layout.chunk_node_end[c]); ++i)
      scratch.patch_pressure[i] += scratch.dilatation[c][i];
  for (int i = begin; i < end; ++i) scratch.patch_pressure[i] *= layout.patch_bulk[i];
}

template <class Real>
void chunkForces(const KernelLayoutOf<Real>& layout, int chunk, const Real4<Real>* u, KernelScratchOf<Real>& scratch) {
  Real4<Real>* f = scratch.force[chunk].data();
  std::fill(f + layout.chunk_node_begin[chunk], f + layout.chunk_node_end[chunk], Real4<Real>{});
  auto& report = scratch.report[chunk];
  report = {};
  for (int batch = layout.chunk_begin[chunk]; batch < layout.chunk_begin[chunk + 1];) {
    const int material_index = layout.batch_material[batch];
    const Material& material = layout.materials[material_index];
    int end = batch;
    while (end < layout.chunk_begin[chunk + 1] && layout.batch_material[end] == material_index) ++end;
    if (material.kind == Material::Kind::NeoHookean)
      batchesForces<NeoHookeanLanes<Real>>(layout, material, batch, end, u, scratch, f, report);
    else
      batchesForces<OgdenLanes<Real>>(layout, material, batch, end, u, scratch, f, report);
    batch = end;
  }
}

/// Runs each(part) for part in [0, count), every member of the team taking an even share.
template <class Each>
void shareOut(SpinTeam& team, int count, Each each) {
  struct Context {
    int count;
    Each& each;
  } context{count, each};
  team.run(
      [](void* c, int member, int members) {
        auto& [n, call] = *static_cast<Context*>(c);
        for (int k = n * member / members; k < n * (member + 1) / members; ++k) call(k);
      },
      &context);
}

}  // namespace

template <class Real>
ForceReport internalForces(const KernelLayoutOf<Real>& layout, const Real4<Real>* u, KernelScratchOf<Real>& scratch, SpinTeam& team) {
  const int chunks = static_cast<int>(scratch.force.size());
  if (!layout.patch_node.empty()) {
    shareOut(team, chunks, [&](int chunk) { chunkDilatation(layout, chunk, u, scratch); });
    const int nodes = layout.node_count;
    shareOut(team, chunks, [&](int part) {
      sumPatches(layout, nodes * part / chunks, nodes * (part + 1) / chunks, scratch);
    });
  }
  shareOut(team, chunks, [&](int chunk) { chunkForces(layout, chunk, u, scratch); });

  ForceReport total;
  for (const auto& r : scratch.report) {
    total.inverted_points += r.inverted;
    if (r.min_J < total.min_J) {
      total.min_J = static_cast<float>(r.min_J);
      total.worst_point = layout.point[r.worst_point];
    }
  }
  return total;
}

template <class Real>
void sumForces(const KernelLayoutOf<Real>& layout, const KernelScratchOf<Real>& scratch, int begin, int end, Real4<Real>* f) {
  std::fill(f + begin, f + end, Real4<Real>{});
  for (std::size_t c = 0; c < scratch.force.size(); ++c) {
    const Real4<Real>* from = scratch.force[c].data();
    for (int i = std::max(begin, layout.chunk_node_begin[c]); i < std::min(end, layout.chunk_node_end[c]); ++i)
      storeGroup(&f[i].x, loadGroup(&f[i].x) + loadGroup(&from[i].x));
  }
}

template ForceReport internalForces(const KernelLayoutOf<float>&, const Float4*, KernelScratchOf<float>&, SpinTeam&);
template ForceReport internalForces(const KernelLayoutOf<double>&, const Double4*, KernelScratchOf<double>&, SpinTeam&);
template void sumForces(const KernelLayoutOf<float>&, const KernelScratchOf<float>&, int, int, Float4*);
template void sumForces(const KernelLayoutOf<double>&, const KernelScratchOf<double>&, int, int, Double4*);

Mat3 deformationGradient(const ShapeTable& shape, int row, const std::vector<Vec3>& u) {
  Mat3 F = Mat3::Identity();
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e)
    F += u[shape.node[e]] * shape.gradN[e].transpose();
  return F;
}

namespace {

/// Pressure of every point: of its node patches, or K (J - 1).
std::vector<double> pressures(const ShapeTable& shape, const std::vector<double>& volume,
                              const std::vector<int>& point_material, const std::vector<Material>& materials,
                              const std::vector<Vec3>& u, const NodePatches& patches) {
  std::vector<double> p;
  for (int q = 0; q < shape.rowCount(); ++q) p.push_back(deformationGradient(shape, q, u).determinant() - 1);
  if (!patches.empty()) return patchPressure(patches, volume, p);
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

double strainEnergy(const ShapeTable& shape, const std::vector<double>& volume,
                    const std::vector<int>& point_material, const std::vector<Material>& materials,
                    const std::vector<Vec3>& u, const NodePatches& patches) {
  double energy = 0;
  std::vector<double> theta(patches.volume.size(), 0);
  for (int q = 0; q < shape.rowCount(); ++q) {
    const Material& material = materials[point_material[q]];
    const Mat3 F = deformationGradient(shape, q, u);
    const double change = F.determinant() - 1;
    energy += volume[q] * material.energy(F);
    if (patches.empty()) continue;
    energy -= volume[q] * 0.5 * material.bulk_modulus * change * change;  // the patches' instead
    for (int a = 0; a < 4; ++a)
      theta[patches.node[q][a]] += volume[q] * patches.weight[q][a] / patches.volume[patches.node[q][a]] * change;
  }
  for (std::size_t a = 0; a < theta.size(); ++a)
    energy += 0.5 * patches.volume[a] * patches.bulk_modulus[a] * theta[a] * theta[a];
  return energy;
}

}  // namespace palpate

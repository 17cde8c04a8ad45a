#include "mechanics/internal_forces.h"

#include <algorithm>

#include "base/float4.h"
#include "mechanics/stress_lanes.h"

namespace palpate {
namespace {

/// Tensors of the 16 points of a batch, in memory between the passes over their quads.
struct alignas(64) BatchTensors {
  float a[9][16];
};

/// Displacement gradients of a quad's four points, into group `k` of the batch.
/// Lanes of a tile: (node of the group, point of the quad).
void displacementGradient(const KernelLayout& layout, const PointQuad& quad, const Float4* u, int k,
                          BatchTensors& H) {
  Lanes sum[9];
  for (auto& s : sum) s = 0.0F;
  const float* tile = layout.gradN.data() + static_cast<std::size_t>(quad.tile_begin) * 48;
  const std::int32_t* node = layout.node.data() + static_cast<std::size_t>(quad.tile_begin) * 4;
  for (int g = 0; g < quad.group_count; ++g, tile += 48, node += 4) {
    __builtin_prefetch(tile + 512);
    __builtin_prefetch(tile + 528);
    __builtin_prefetch(tile + 544);
    const Lanes xyz = Lanes::gather(&u[node[0]].x, &u[node[1]].x, &u[node[2]].x, &u[node[3]].x);
    const Lanes ux = spread<0>(xyz), uy = spread<1>(xyz), uz = spread<2>(xyz);
    for (int b = 0; b < 3; ++b) {
      const Lanes grad = Lanes::load(tile + 16 * b);
      sum[b] += ux * grad;
      sum[3 + b] += uy * grad;
      sum[6 + b] += uz * grad;
    }
  }
  for (int c = 0; c < 9; ++c) {
    alignas(64) float s[16];
    sum[c].store(s);
    storeGroup(H.a[c] + 4 * k, (loadGroup(s) + loadGroup(s + 4)) + (loadGroup(s + 8) + loadGroup(s + 12)));
  }
}

/// Adds -V P gradN of a quad's four points to the forces of its nodes; PV holds V P.
void scatterForces(const KernelLayout& layout, const PointQuad& quad, int k, const BatchTensors& PV, Float4* f) {
  Lanes p[9];
  for (int c = 0; c < 9; ++c) {
    const float* a = PV.a[c] + 4 * k;
    p[c] = Lanes::gather(a, a, a, a);
  }
  const float* tile = layout.gradN.data() + static_cast<std::size_t>(quad.tile_begin) * 48;
  const std::int32_t* node = layout.node.data() + static_cast<std::size_t>(quad.tile_begin) * 4;
  for (int g = 0; g < quad.group_count; ++g, tile += 48, node += 4) {
    const Lanes g0 = Lanes::load(tile), g1 = Lanes::load(tile + 16), g2 = Lanes::load(tile + 32);
    const Lanes fx = p[0] * g0 + p[1] * g1 + p[2] * g2;
    const Lanes fy = p[3] * g0 + p[4] * g1 + p[5] * g2;
    const Lanes fz = p[6] * g0 + p[7] * g1 + p[8] * g2;
    alignas(64) float sum[16];
    groupSums(fx, fy, fz).store(sum);
    for (int n = 0; n < 4; ++n) {
      float* fn = &f[node[n]].x;
      storeGroup(fn, loadGroup(fn) - loadGroup(sum + 4 * n));
    }
  }
}

template <class MaterialLanes>
void batchForces(const KernelLayout& layout, const MaterialLanes& material, int batch, const Float4* u, Float4* f,
                 KernelScratch::ChunkReport& report) {
  BatchTensors tensors;
  const PointQuad* quads = &layout.quads[static_cast<std::size_t>(batch) * 4];
  for (int k = 0; k < 4; ++k) displacementGradient(layout, quads[k], u, k, tensors);

  TensorLanes H, P;
  for (int c = 0; c < 9; ++c) H[c] = Lanes::load(tensors.a[c]);
  const Lanes J = material.firstPiola(H, P);
  const Lanes volume = Lanes::load(&layout.volume[static_cast<std::size_t>(batch) * 16]);
  for (int c = 0; c < 9; ++c) (P[c] * volume).store(tensors.a[c]);

  alignas(64) float j[16];
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

  for (int k = 0; k < 4; ++k) scatterForces(layout, quads[k], k, tensors, f);
}

void chunkForces(const KernelLayout& layout, int chunk, const Float4* u, KernelScratch& scratch) {
  Float4* f = scratch.force[chunk].data();
  std::fill(f + layout.chunk_node_begin[chunk], f + layout.chunk_node_end[chunk], Float4{});
  auto& report = scratch.report[chunk];
  report = {};
  for (int batch = layout.chunk_begin[chunk]; batch < layout.chunk_begin[chunk + 1];) {
    const int material_index = layout.batch_material[batch];
    const Material& material = layout.materials[material_index];
    int end = batch;
    while (end < layout.chunk_begin[chunk + 1] && layout.batch_material[end] == material_index) ++end;
    if (material.kind == Material::Kind::NeoHookean) {
      const NeoHookeanLanes lanes(material);
      for (; batch < end; ++batch) batchForces(layout, lanes, batch, u, f, report);
    } else {
      const OgdenLanes lanes(material);
      for (; batch < end; ++batch) batchForces(layout, lanes, batch, u, f, report);
    }
  }
}

}  // namespace

ForceReport internalForces(const KernelLayout& layout, const Float4* u, KernelScratch& scratch, SpinTeam& team) {
  struct Context {
    const KernelLayout& layout;
    const Float4* u;
    KernelScratch& scratch;
  } context{layout, u, scratch};
  team.run(
      [](void* c, int member, int members) {
        auto& [lay, disp, scr] = *static_cast<Context*>(c);
        const int chunks = static_cast<int>(scr.force.size());
        for (int k = chunks * member / members; k < chunks * (member + 1) / members; ++k)
          chunkForces(lay, k, disp, scr);
      },
      &context);

  ForceReport total;
  for (const auto& r : scratch.report) {
    total.inverted_points += r.inverted;
    if (r.min_J < total.min_J) {
      total.min_J = r.min_J;
      total.worst_point = layout.point[r.worst_point];
    }
  }
  return total;
}

void sumForces(const KernelLayout& layout, const KernelScratch& scratch, int begin, int end, Float4* f) {
  std::fill(f + begin, f + end, Float4{});
  for (std::size_t c = 0; c < scratch.force.size(); ++c) {
    const Float4* from = scratch.force[c].data();
    for (int i = std::max(begin, layout.chunk_node_begin[c]); i < std::min(end, layout.chunk_node_end[c]); ++i)
      storeGroup(&f[i].x, loadGroup(&f[i].x) + loadGroup(&from[i].x));
  }
}

Mat3 deformationGradient(const ShapeTable& shape, int row, const std::vector<Vec3>& u) {
  Mat3 F = Mat3::Identity();
  for (int e = shape.begin[row]; e < shape.begin[row + 1]; ++e)
    F += u[shape.node[e]] * shape.gradN[e].transpose();
  return F;
}

void referenceInternalForces(const ShapeTable& shape, const std::vector<double>& volume,
                             const std::vector<int>& point_material, const std::vector<Material>& materials,
                             const std::vector<Vec3>& u, std::vector<Vec3>& f) {
  f.assign(u.size(), Vec3::Zero());
  for (int q = 0; q < shape.rowCount(); ++q) {
    const Mat3 PV = volume[q] * materials[point_material[q]].firstPiola(deformationGradient(shape, q, u));
    for (int e = shape.begin[q]; e < shape.begin[q + 1]; ++e) f[shape.node[e]] -= PV * shape.gradN[e];
  }
}

double strainEnergy(const ShapeTable& shape, const std::vector<double>& volume,
                    const std::vector<int>& point_material, const std::vector<Material>& materials,
                    const std::vector<Vec3>& u) {
  double energy = 0;
  for (int q = 0; q < shape.rowCount(); ++q)
    energy += volume[q] * materials[point_material[q]].energy(deformationGradient(shape, q, u));
  return energy;
}

}  // namespace palpate

#include "mechanics/kernel_layout.h"

#include <algorithm>
#include <cmath>

#include "discretization/node_order.h"

namespace palpate {
namespace {

/// Work packages of one force evaluation. More than the threads we expect, so that a late
/// worker costs little; few enough that summing the buffers stays below a few percent.
constexpr int chunk_count = 4;

/// Points of one material after another, each in bisection order, every material padded with -1
/// to whole batches.
std::vector<int> batchOrder(const std::vector<Vec3>& point_X, const std::vector<int>& point_material,
                            int material_count, std::vector<int>& batch_material) {
  std::vector<int> order;
  for (int m = 0; m < material_count; ++m) {
    std::vector<int> mine;
    std::vector<Vec3> X;
    for (int q = 0; q < static_cast<int>(point_X.size()); ++q)
      if (point_material[q] == m) {
        mine.push_back(q);
        X.push_back(point_X[q]);
      }
    for (int k : bisectionOrder(X, 4)) order.push_back(mine[k]);
    while (order.size() % 16 != 0) order.push_back(-1);
    batch_material.resize(order.size() / 16, m);
  }
  return order;
}

/// Padding points have zero share and weight; they point at node of their batch's first point, so that a
/// chunk touches no node outside its range.
template <class Real>
void addPatches(KernelLayoutOf<Real>& layout, const std::vector<double>& volume, const NodePatches& patches) {
  const std::size_t batches = layout.batch_material.size();
  layout.patch_node.assign(batches * 64, 0);
  layout.patch_share.assign(batches * 64, Real(0));
  layout.patch_weight.assign(batches * 64, Real(0));
  layout.patch_bulk.resize(patches.volume.size());
  for (std::size_t slot = 0; slot < layout.point.size(); ++slot) {
    const int q = layout.point[slot];
    const int source = q >= 0 ? q : layout.point[slot / 16 * 16];
    for (int a = 0; a < 4; ++a) {
      const std::size_t at = slot / 16 * 64 + static_cast<std::size_t>(a) * 16 + slot % 16;
      const int node = patches.node[source][a];
      layout.patch_node[at] = node;
      if (q < 0) continue;
      layout.patch_share[at] = static_cast<Real>(volume[q] * patches.weight[q][a] / patches.volume[node]);
      layout.patch_weight[at] = static_cast<Real>(patches.weight[q][a]);
    }
  }
  updatePatchBulk(layout);
}

}  // namespace

template <class Real>
void updatePatchBulk(KernelLayoutOf<Real>& layout) {
  std::fill(layout.patch_bulk.begin(), layout.patch_bulk.end(), Real(0));
  // A patch's shares sum to 1, so this is the harmonic mean of the bulk moduli in it.
  for (std::size_t i = 0; i < layout.patch_node.size(); ++i)
    layout.patch_bulk[layout.patch_node[i]] +=
        layout.patch_share[i] / static_cast<Real>(layout.materials[layout.batch_material[i / 64]].bulk_modulus);
  for (Real& k : layout.patch_bulk) k = k > 0 ? 1 / k : 0;
}

template <class Real>
KernelLayoutOf<Real> makeKernelLayout(const ShapeTable& shape, const std::vector<Vec3>& point_X,
                              const std::vector<double>& volume, const std::vector<int>& point_material,
                              const std::vector<Material>& materials, int node_count, const NodePatches& patches) {
  KernelLayoutOf<Real> layout;
  layout.node_count = node_count;
  layout.point_count = static_cast<int>(point_X.size());
  layout.materials = materials;
  layout.point = batchOrder(point_X, point_material, static_cast<int>(materials.size()), layout.batch_material);

  std::vector<int> nodes;
  for (std::size_t first = 0; first < layout.point.size(); first += 4) {
    const int* point = &layout.point[first];
    nodes.clear();
    for (int p = 0; p < 4; ++p)
      if (point[p] >= 0)
        nodes.insert(nodes.end(), shape.node.begin() + shape.begin[point[p]],
                     shape.node.begin() + shape.begin[point[p] + 1]);
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    // Padding repeats the quad's first nodes, whose forces were stored long before: a repeat of the
    // last one would wait for its store.
    const int union_count = static_cast<int>(nodes.size());
    for (int k = 0; nodes.size() % 4 != 0; ++k) nodes.push_back(nodes[k]);

    PointQuad quad;
    quad.tile_begin = static_cast<int>(layout.node.size() / 4);
    quad.group_count = static_cast<int>(nodes.size() / 4);
    layout.quads.push_back(quad);
    layout.node.insert(layout.node.end(), nodes.begin(), nodes.end());
    layout.gradN.resize(layout.node.size() * 12, Real(0));
    Real* tiles = layout.gradN.data() + static_cast<std::size_t>(quad.tile_begin) * 48;
    for (int p = 0; p < 4; ++p) {
      layout.volume.push_back(point[p] < 0 ? Real(0) : static_cast<Real>(volume[point[p]]));
      if (point[p] < 0) continue;
      for (int e = shape.begin[point[p]]; e < shape.begin[point[p] + 1]; ++e) {
        const auto at = std::lower_bound(nodes.begin(), nodes.begin() + union_count, shape.node[e]) - nodes.begin();
        for (int b = 0; b < 3; ++b)
          tiles[(at / 4) * 48 + b * 16 + (at % 4) * 4 + p] = static_cast<Real>(shape.gradN[e][b]);
      }
    }
  }

  if (!patches.empty()) addPatches(layout, volume, patches);
  const int batches = static_cast<int>(layout.batch_material.size());
  for (int c = 0; c <= chunk_count; ++c) layout.chunk_begin.push_back(batches * c / chunk_count);
  for (int c = 0; c < chunk_count; ++c) {
    int begin = node_count, end = 0;
    for (int q = layout.chunk_begin[c] * 4; q < layout.chunk_begin[c + 1] * 4; ++q)
      for (int k = 0; k < layout.quads[q].group_count * 4; ++k) {
        const int node = layout.node[static_cast<std::size_t>(layout.quads[q].tile_begin) * 4 + k];
        begin = std::min(begin, node);
        end = std::max(end, node + 1);
      }
    for (int b = layout.chunk_begin[c] * 64; b < layout.chunk_begin[c + 1] * 64 && !layout.patch_node.empty(); ++b) {
      begin = std::min(begin, layout.patch_node[b]);
      end = std::max(end, layout.patch_node[b] + 1);
    }
    layout.chunk_node_begin.push_back(std::min(begin, end));
    layout.chunk_node_end.push_back(end);
  }
  return layout;
}

template <class Real>
KernelScratchOf<Real> makeKernelScratch(const KernelLayoutOf<Real>& layout) {
  KernelScratchOf<Real> scratch;
  scratch.force.assign(layout.chunk_begin.size() - 1, AlignedVector<Real4<Real>>(layout.node_count));
  scratch.report.resize(scratch.force.size());
  if (!layout.patch_node.empty()) {
    scratch.displacement_gradient.resize(layout.batch_material.size() * 144);
    scratch.dilatation.assign(scratch.force.size(), AlignedVector<Real>(layout.node_count));
    scratch.patch_pressure.resize(layout.node_count);
  }
  return scratch;
}

template void updatePatchBulk(KernelLayoutOf<float>&);
template KernelLayoutOf<float> makeKernelLayout(const ShapeTable&, const std::vector<Vec3>&, const std::vector<double>&,
                                       const std::vector<int>&, const std::vector<Material>&, int, const NodePatches&);
template KernelScratchOf<float> makeKernelScratch(const KernelLayoutOf<float>&);
template void updatePatchBulk(KernelLayoutOf<double>&);
template KernelLayoutOf<double> makeKernelLayout(const ShapeTable&, const std::vector<Vec3>&, const std::vector<double>&,
                                       const std::vector<int>&, const std::vector<Material>&, int, const NodePatches&);
template KernelScratchOf<double> makeKernelScratch(const KernelLayoutOf<double>&);

}  // namespace palpate

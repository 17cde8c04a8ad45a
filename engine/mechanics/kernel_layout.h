#pragma once

#include <cstdint>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "mechanics/material.h"
#include "mechanics/node_patch.h"

namespace palpate {

/// Four neighbouring integration points that share one union support.
struct PointQuad {
  int tile_begin = 0;    // first tile (of 48 floats) in gradN, and first group of 4 in node
  int group_count = 0;   // groups of 4 union nodes
};

/// What the internal-force kernel streams, in float for the real-time loop or in double for the batch solver: integration points in quads, quads in
/// batches of four (16 points, one vector of lanes), batches in chunks that
/// threads take whole. A quad's points share most of their nodes, so that a node's
/// displacement is loaded and its force stored once for four points.
template <class Real>
struct KernelLayoutOf {
  int node_count = 0;
  int point_count = 0;                        // real points; the last batch is padded with zero volume
  std::vector<PointQuad> quads;               // (4 * batch_count)
  AlignedVector<std::int32_t> node;           // (4 * group_count) union nodes; padding has zero gradient
  AlignedVector<Real> gradN;                 // (48 * group_count) tiles [component 3][node 4][point 4], 1/m
  AlignedVector<Real> volume;                // (16 * batch_count) m^3
  std::vector<int> point;                     // (16 * batch_count) index in the model, or -1 for padding
  std::vector<int> batch_material;            // (batch_count)
  std::vector<Material> materials;
  // Node-patch volume (node_patch.h); empty where the scene does without. [vertex 4][point 16] per batch.
  std::vector<std::int32_t> patch_node;       // (64 * batch_count)
  AlignedVector<Real> patch_share;           // (64 * batch_count) s_aq
  AlignedVector<Real> patch_weight;          // (64 * batch_count) l_a(x_q)
  AlignedVector<Real> patch_bulk;            // (node_count) K_a, Pa
  // Chunks: fixed work packages, so that the sum over them does not depend on the thread count.
  std::vector<int> chunk_begin;               // (chunk_count + 1) batches
  std::vector<int> chunk_node_begin, chunk_node_end;  // (chunk_count) range of nodes that a chunk touches
};

using KernelLayout = KernelLayoutOf<float>;

template <class Real>
struct KernelScratchOf {
  std::vector<AlignedVector<Real4<Real>>> force;   // (chunk_count)(node_count) N; a chunk uses its range only
  struct ChunkReport {
    Real min_J = 1;
    int worst_point = -1;
    int inverted = 0;
  };
  std::vector<ChunkReport> report;            // (chunk_count)
  // Between the two passes of the node-patch volume.
  AlignedVector<Real> displacement_gradient; // (9 * 16 * batch_count)
  std::vector<AlignedVector<Real>> dilatation;  // (chunk_count)(node_count) a chunk's share of theta_a
  AlignedVector<Real> patch_pressure;        // (node_count) K_a theta_a, Pa
};

using KernelScratch = KernelScratchOf<float>;

/// @param shape           one row per integration point, with gradients
/// @param point_X         m (point_count): points are grouped by place
/// @param volume          m^3 (point_count)
/// @param point_material  index into `materials` (point_count)
/// @param patches         node patches of the points, or empty for pointwise volume
template <class Real = float>
KernelLayoutOf<Real> makeKernelLayout(const ShapeTable& shape, const std::vector<Vec3>& point_X,
                                      const std::vector<double>& volume, const std::vector<int>& point_material,
                                      const std::vector<Material>& materials, int node_count,
                                      const NodePatches& patches = {});

/// K_a of all patches from the layout's materials; after one of these changed. Real-time.
template <class Real>
void updatePatchBulk(KernelLayoutOf<Real>& layout);

template <class Real>
KernelScratchOf<Real> makeKernelScratch(const KernelLayoutOf<Real>& layout);

}  // namespace palpate

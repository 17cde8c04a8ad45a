#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "approximation/shape_table.h"
#include "base/types.h"
#include "mechanics/cell_volume.h"
#include "mechanics/gradient_precision.h"
#include "mechanics/kernel_passes.h"
#include "mechanics/materials/material.h"
#include "mechanics/node_patch.h"

namespace palpate {

/// The data that the internal-force kernel reads, in float for the real-time loop or in double for the batch solver:
/// integration points in blocks of four, blocks in batches of four (16 points, one vector of lanes), batches in chunks,
/// each of which one thread computes. A block's points share most of their nodes, so that a node's displacement is
/// loaded and its force stored once for four points.
///
/// With 16-bit gradients, the gradients of a block's first four union nodes, its anchors, stay in float. The rounding
/// errors of the other nodes are added to them, so that sum_j gradN_j and sum_j gradN_j (x) X_j are as exact as in
/// float32. Otherwise rounding would cause an error of J under any rotation, which near-incompressibility multiplies.
template <class Real>
struct KernelLayoutOf {
  int node_count = 0;
  int point_count = 0;               // real points; the last batch is padded with zero volume
  std::vector<PointBlock> blocks;    // (4 * batch_count)
  AlignedVector<std::int32_t> node;  // (4 * group_count) union nodes; padding has zero gradient. Empty in favour of
  AlignedVector<std::uint16_t> short_node;    // the same, for float where all numbers fit
  AlignedVector<Real> gradN;                  // (48 * group_count) tiles [component 3][node 4][point 4], 1/m;
                                              // 16-bit: (48 * block_count) the anchors' tiles, in units of scale
  AlignedVector<std::int16_t> rounded_gradN;  // 16-bit: (48 * other group_count) tiles of the others, in units of scale
  AlignedVector<Real> scale;                  // 16-bit: (48 * batch_count) [component 3][point 16] per batch, 1/m
  AlignedVector<Real> volume;                 // (16 * batch_count) m^3
  std::vector<int> point;                     // (16 * batch_count) index in the model, or -1 for padding
  std::vector<int> batch_material;            // (batch_count)
  // Where materials mix (a point's material is another than its batch's): of the point's moduli over the batch's
  // material's; empty where none do. Stresses are in proportion to the shear modulus once the pressure is divided by
  // the same share, which is in patch_weight: the kernel needs to know of nothing but another volume.
  AlignedVector<Real> stress_volume;            // (16 * batch_count) m^3, volume times shear_share
  AlignedVector<Real> shear_share, bulk_share;  // (16 * batch_count)
  // Node-patch volume (node_patch.h); empty where the scene does without.
  std::vector<int> patch_begin;           // (patch_count + 1) entries of each patch in; patches of nodes, and after
                                          // them of a border's further sides
  std::vector<std::int32_t> patch_point;  // its points' places in `point`, ascending, and
  AlignedVector<Real> patch_share;        // s_aq
  std::vector<std::int32_t> patch_node;   // patches of the points (64 * batch_count) [vertex 4][point 16] per batch
  AlignedVector<Real> patch_weight;       // (64 * batch_count) (1 - o_q) l_a(x_q)
  AlignedVector<Real> own_bulk;    // (16 * batch_count) o_q, over the batch's material's bulk modulus and divided
                                   // by shear_share; empty: patches average all
  CellVolumeOf<Real> cell_volume;  // takes over under pressure; empty: nothing does
  // Chunks: fixed work packages, so that the sum over them does not depend on the thread count.
  std::vector<int> chunk_begin;                       // (chunk_count + 1) batches
  std::vector<int> chunk_node_begin, chunk_node_end;  // (chunk_count) range of nodes that a chunk touches
};

using KernelLayout = KernelLayoutOf<float>;

/// Data of the kernel that may change from step to step. The layout itself is constant, and many bodies may share it.
template <class Real>
struct KernelMaterialsOf {
  std::vector<Material> materials;  // (material_count) that batch_material counts
  AlignedVector<Real> patch_bulk;   // (patch_count) K_a, Pa, by updatePatchBulk; empty without node patches
  AlignedVector<Real> patch_shear;  // (patch_count) least shear modulus of the patch, Pa, by the same
  Real pressed_dilatation = 0;      // from which on cell_volume.h looks at a point, by the same
};

using KernelMaterials = KernelMaterialsOf<float>;

template <class Real>
struct KernelScratchOf {
  const KernelPasses<Real>* passes = nullptr;  // of the instruction set that the scratch was made for
  AlignedVector<Real4<Real>> force;            // (chunk_count)(node_count) N; a chunk uses its range only
  std::vector<typename KernelView<Real>::ChunkReport> report;  // (chunk_count)
  // (16 * batch_count) |cof F|^2 and det F of each point, and the bound of its tangent (PointStateOf), Pa.
  AlignedVector<Real> cof2, J, squeeze, other;
  // Between the two passes of the node-patch volume.
  AlignedVector<Real> displacement_gradient;  // (9 * 16 * batch_count)
  AlignedVector<Real> dilatation;             // (16 * batch_count) J - 1
  AlignedVector<Real> patch_pressure;         // (patch_count) K_a theta_a, Pa; bounded where there is cell_volume
  CellVolumeScratchOf<Real> cell_volume;
};

using KernelScratch = KernelScratchOf<float>;

/// @param shape           one row per integration point, with gradients
/// @param point_X         m (point_count): points are grouped by place
/// @param volume          m^3 (point_count)
/// @param point_material  index into `materials` (point_count)
/// @param patches         node patches of the points, or empty for pointwise volume
/// @param gradients       Int16: float only, and X is needed
/// @param X               nodes, m (node_count)
/// @param base            of each material the one by whose law and moduli the kernel computes it, so that their
///                        points share batches (material_count); they differ in moduli only, and without patches in
///                        one factor. Empty: each by itself
/// Throws InputError where Int16 can't be: the nodes around a block of points lie in one plane.
template <class Real = float>
KernelLayoutOf<Real> makeKernelLayout(const ShapeTable& shape, const std::vector<Vec3>& point_X,
                                      const std::vector<double>& volume, const std::vector<int>& point_material,
                                      const std::vector<Material>& materials, int node_count,
                                      const NodePatches& patches = {},
                                      GradientPrecision gradients = GradientPrecision::Float32,
                                      const std::vector<Vec3>& X = {}, const std::vector<int>& base = {});

/// Materials for a layout, with the K_a of its patches.
template <class Real>
KernelMaterialsOf<Real> makeKernelMaterials(const KernelLayoutOf<Real>& layout, std::vector<Material> materials);

/// K_a and least shear modulus (what relaxes left out) of all patches from the materials; after one of these changed.
/// Real-time.
template <class Real>
void updatePatchBulk(const KernelLayoutOf<Real>& layout, KernelMaterialsOf<Real>& materials);

/// @param set  of supportedInstructionSets()
/// Throws InputError when PALPATE_KERNEL names none, as chosenInstructionSet does.
template <class Real>
KernelScratchOf<Real> makeKernelScratch(const KernelLayoutOf<Real>& layout,
                                        InstructionSet set = chosenInstructionSet());

}  // namespace palpate

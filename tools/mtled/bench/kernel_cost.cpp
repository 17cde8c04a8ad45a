#include "mtled/bench/kernel_cost.h"

namespace palpate::tools {
namespace {

// Of mechanics/internal_forces.cpp, in lanes that are used or padding alike.
// Per group of 4 nodes and 4 points: 9 multiply-adds for F (288), 15 operations for V P gradN (240), three sums
// across points (48), 4 nodes' forces (16).
constexpr double flops_per_group = 592;
// Per block: the sum over the 4 nodes of a group, 3 additions of 4 lanes for each of 9 components.
constexpr double flops_per_block = 108;
// Per point, mechanics/simd_stress.h: F 3, cofactor 27, J 27, I1 17, J^(-2/3) and its slope 25, factors 5, P 27, V P 9.
constexpr double flops_per_point = 140;
// Per point with 16-bit gradients: H and P by the gradients' scale.
constexpr double scale_flops_per_point = 18;
// Per point with node patches: J once more 26, its four shares 8, the pressure from four nodes 8.
constexpr double patch_flops_per_point = 42;

template <class Vector>
double bytesOf(const Vector& v) {
  return static_cast<double>(v.size() * sizeof(v[0]));
}

}  // namespace

double usefulFlops(const ShapeTable& shape) {
  return 36.0 * static_cast<double>(shape.node.size()) + 95.0 * shape.rowCount();
}

template <class Real>
KernelCost blockKernelCost(const KernelLayoutOf<Real>& layout, const ShapeTable& shape) {
  double touched = 0;  // nodes of all chunks; those of two chunks twice
  for (std::size_t c = 0; c < layout.chunk_node_begin.size(); ++c)
    touched += layout.chunk_node_end[c] - layout.chunk_node_begin[c];
  const double tables = bytesOf(layout.gradN) + bytesOf(layout.rounded_gradN) + bytesOf(layout.node) +
                        bytesOf(layout.short_node) + bytesOf(layout.blocks);
  const double scales = bytesOf(layout.scale), points = bytesOf(layout.volume) + bytesOf(layout.batch_material);
  const double u = layout.node_count * static_cast<double>(sizeof(Real4<Real>)), forces = touched * sizeof(Real4<Real>);

  KernelCost cost;
  cost.useful_flops = usefulFlops(shape);
  double groups = 0;
  for (const PointBlock& block : layout.blocks) groups += block.group_count;
  const auto blocks = static_cast<double>(layout.blocks.size()),
             padded_points = static_cast<double>(layout.volume.size());
  cost.executed_flops = groups * flops_per_group + blocks * flops_per_block + padded_points * flops_per_point;
  if (!layout.scale.empty()) cost.executed_flops += padded_points * scale_flops_per_point;
  cost.streamed_bytes = cost.working_set = tables + scales + points + u + forces;
  if (layout.patch_begin.empty()) return cost;

  const double tensors = 9 * bytesOf(layout.volume);
  const double per_node = layout.node_count * static_cast<double>(sizeof(Real)), dilatation = bytesOf(layout.volume);
  const double patches = bytesOf(layout.patch_begin) + bytesOf(layout.patch_point) + bytesOf(layout.patch_share) +
                         bytesOf(layout.patch_node) + bytesOf(layout.patch_weight);
  cost.working_set += tensors + patches + 2 * per_node + dilatation;  // bulk moduli and pressures
  // The gradients are kept between the passes, but the forces need the tiles again.
  cost.streamed_bytes += tables + scales + 2 * tensors + patches + 3 * per_node + 2 * dilatation;
  cost.executed_flops += padded_points * patch_flops_per_point;
  return cost;
}

template KernelCost blockKernelCost(const KernelLayoutOf<float>&, const ShapeTable&);
template KernelCost blockKernelCost(const KernelLayoutOf<double>&, const ShapeTable&);

}  // namespace palpate::tools

#pragma once

#include "approximation/shape_table.h"
#include "mechanics/kernel_layout.h"

namespace palpate::tools {

/// What one force evaluation moves and computes, counted from the layout of its data; nothing is measured.
struct KernelCost {
  double streamed_bytes = 0;  // each table once per pass, what lies between two passes written and read, each
                              // node's vectors once; a batch's second look at its tiles hits the nearest cache
  double working_set = 0;     // bytes that should stay in a cache from one evaluation to the next
  double useful_flops = 0;    // 36 n + 95 for a point with n nodes; a multiply-add is 2
  double executed_flops = 0;  // with padded nodes and points, and reductions
};

/// Useful arithmetic of one pass over the points, whatever the layout: 9 multiply-adds per node for F and 9 for
/// the forces, 95 for a neo-Hookean stress times volume.
double usefulFlops(const ShapeTable& shape);

/// Of the block kernel (mechanics/internal_forces.cpp) with neo-Hookean material.
/// Test: tools/bench_command_test.cpp (counted by hand)
template <class Real>
KernelCost blockKernelCost(const KernelLayoutOf<Real>& layout, const ShapeTable& shape);

}  // namespace palpate::tools

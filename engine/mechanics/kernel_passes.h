#pragma once

#include <cstdint>

#include "base/instruction_set.h"
#include "base/types.h"
#include "mechanics/materials/material.h"

namespace palpate {

/// Four neighbouring integration points that share one union support.
struct PointBlock {
  int tile_begin = 0;     // its first group of 4 in node, and its first tile (of 48) in gradN if these are Real
  int rounded_begin = 0;  // its first tile in rounded_gradN; its anchor tile is gradN's number `block`
  int group_count = 0;    // groups of 4 union nodes, the anchors' included
};

/// Arrays of KernelLayoutOf and KernelScratchOf as the passes see them: plain pointers, since code that is compiled for
/// several instruction sets may use no inline function of std (base/kernel_namespace.h). Shapes stand there.
template <class Real>
struct KernelView {
  int node_count;
  const PointBlock* blocks;
  const std::int32_t* node;  // null where short_node is there
  const std::uint16_t* short_node;
  const Real* gradN;
  const std::int16_t* rounded_gradN;  // null: gradN has all
  const Real* scale;
  const Real* volume;
  const Real* stress_volume;  // `volume` itself where no materials mix
  const int* batch_material;
  const Material* materials;
  const int* patch_begin;  // null: no patches
  const std::int32_t* patch_point;
  const Real* patch_share;
  const Real* patch_bulk;
  const std::int32_t* patch_node;
  const Real* patch_weight;
  const Real* own_bulk;  // null: patches average all
  const int* chunk_begin;
  const int* chunk_node_begin;
  const int* chunk_node_end;
  int chunk_count;

  struct ChunkReport {
    Real min_J;
    int worst_point;  // place in the layout's points, or -1
    int inverted;
    Real energy;          // J
    Real volume_change;   // m^3
    Real max_cof2;        // largest |cof F|^2 of a point
    Real max_squeeze;     // largest PointStateOf::squeeze, and squeeze + other, of a point over its material's modulus
    Real max_modulus;     // at rest
    Real max_pressure;    // largest of a point's patches over its material's shear modulus; 0 without patches
    Real relaxed_energy;  // J and W, of ForceReport
    Real relaxation_power;
  };
  Real4<Real>* force;
  ChunkReport* report;
  Real* displacement_gradient;
  Real* dilatation;
  Real* patch_pressure;
  Real* cof2;
  Real* J;
  Real* squeeze;
  Real* other;
  // Relaxation (relaxation.h).
  int relaxation_terms;    // that count
  double relaxation_step;  // s; infinity with no history
  Real* relaxation;        // RelaxationHistoryOf::Z; null: none
};

/// The kernel's work in parts that threads can share; one after the other.
template <class Real>
struct KernelPasses {
  /// First pass of the node-patch volume: each point's gradient and J - 1 are kept.
  void (*dilatation)(const KernelView<Real>& k, int chunk, const Real4<Real>* u);
  /// K_a theta_a of nodes [begin, end).
  void (*sumPatches)(const KernelView<Real>& k, int begin, int end);
  /// Forces of a chunk's points, into its own buffer.
  void (*forces)(const KernelView<Real>& k, int chunk, const Real4<Real>* u);
};

/// The passes for one instruction set: kernel_passes.cpp, compiled for that.
template <InstructionSet set, class Real>
const KernelPasses<Real>& passesFor();

}  // namespace palpate

#pragma once

#include "base/types.h"
#include "contact/contact.h"
#include "mechanics/essential_boundary.h"
#include "mechanics/kernel_layout.h"
#include "mechanics/local_mass.h"
#include "simulation/body.h"

namespace palpate {

/// A scene made ready to run. Never changes during a run (what is set live is in State), so simulations may share one.
struct Model : Body {
  // Computed from the materials and the cells.
  AlignedVector<float> inverse_mass;  // (node_count) 1/kg
  NodePatches patches;                // empty without scene.node_patch_volume
  AlignedVector<Double4> weight;      // (node_count) N; empty without scene.gravity
  KernelLayout kernel;                // what the hot kernel reads
  EssentialBoundary boundary;         // of `essential` and the masses
  Skull skull;                        // empty where scene.skull is not given
  StiffnessMeans stiffness_means;     // how masses follow the stiffness of squeezed tissue

  double rest_energy = 0;     // J, strain energy below which is rounding
  double max_increment = 0;   // m a node may move in one step; more is a blow-up
  double max_tool_force = 0;  // N, at which the tool advances no further (realtime/loop/tool_proxy.h); 0: none

  /// What takes over from the patches under pressure, where the scene asks for it.
  bool hasCellVolume() const { return scene.cell_volume && !patches.empty(); }
  CellVolumeSpec cellVolume() const { return {X, cells, node_shape, patches, &imposed}; }
};

}  // namespace palpate

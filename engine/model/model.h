#pragma once

#include "base/types.h"
#include "contact/contact.h"
#include "mechanics/essential_boundary.h"
#include "mechanics/kernel_layout.h"
#include "mechanics/local_mass.h"
#include "model/body.h"
#include "model/held_tissue.h"
#include "model/point_groups.h"
#include "model/surface_loads.h"

namespace palpate {

/// A scene made ready to run. Never changes during a run (what is set live is in State), so simulations may share one.
struct Model : Body {
  // Computed from the materials and the cells.
  AlignedVector<float> inverse_mass;  // (node_count) 1/kg
  AlignedVector<float> own_share;     // (node_count) of the mass that is the tissue's, and damps; empty: all
  NodePatches patches;                // empty where nothing is to be averaged (needsPatches)
  AlignedVector<Double4> weight;      // (node_count) N; empty without scene.dynamics.gravity
  SurfaceLoads surface_loads;         // empty without scene.loads
  KernelLayout kernel;                // what the hot kernel reads
  EssentialBoundary boundary;         // of `essential` and the masses
  RigidBodies rigid;                  // of scene.rigid
  HeldTissue held;                    // that tools stand before
  // (vertex_count) of the skin: nodes move it that displacements are imposed on. Empty: there are none
  std::vector<std::uint8_t> beside_held;
  StiffnessMeans stiffness_means;  // how masses follow the stiffness of squeezed tissue
  PointGroups point_groups;        // for the error to expect (expected_error.h)

  double rest_energy = 0;    // J, strain energy below which is rounding
  double max_increment = 0;  // m a node may move in one step; more is a blow-up

  /// What takes over from the patches under pressure.
  bool hasCellVolume() const { return !kernel.cell_volume.empty(); }
  CellVolumeSpec cellVolume() const {
    return {verticesOf(X, side_node),
            volume_cells.empty() ? cells : volume_cells,
            nodeCount(),
            vertexShape(node_shape, side_node),
            patches,
            verticesOf(imposed, side_node)};
  }
};

}  // namespace palpate

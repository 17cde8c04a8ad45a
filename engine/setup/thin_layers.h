#pragma once

#include <array>
#include <vector>

#include "discretization/surface/surface_tree.h"
#include "model/preparation.h"
#include "scene/scene.h"

namespace palpate {

/// A material of which the background cells, each of the material at its middle, see little: a layer thinner than they
/// are. Where tissue deforms smoothly in spite of it, nothing else tells (a soft base of 2 mm under nodes 7 mm apart:
/// force a fifth too large, 2 % expected).
/// And so does a material with a membership whose borders run through cells: these have the geometric mean of the
/// moduli, which is stiffer than tissue upon the other (a column of 20 kPa with a layer of 2 kPa and 10 mm, nodes 5 mm
/// apart, was 23 % too stiff by the arithmetic one).
struct ThinLayer {
  int material = -1;  // index into the scene's, where it should be told of; -1: there is none
  // To expect of forces: half of the share of its volume that cells have for other materials, as far as these are as
  // stiff (1 - softer / stiffer shear modulus); of a membership as below.
  double error = 0;
  std::vector<MissedShare> missed = {};  // that this follows from, of all materials; of a membership none
};

/// The worst one. Cells see 97 % or more of lumps and borders that nodes are put on, 84 % of a ball of 1.5 spacings
/// radius (4 % off, as expected without); 65 to 0 % of layers that made forces 15 to 30 % wrong. So what is below a
/// quarter counts as seen. Where tissue mixes by a membership, the body's compliance with all in series, as the image
/// has it at places within the cells, over that with the cells' means, less 1, times 2: 49 % for 35, 50 for 50, 29 for
/// 23, and of a ball over such a layer 69 for 100 and 24 for 27. None where measured points move the organ: their
/// displacements are wanted of it, not forces.
/// @param cell_material  (cell_count)
/// Test: simulation/thin_layers_test.cpp
ThinLayer thinnestLayer(const Scene& scene, const SurfaceTree& organ, const std::vector<Vec3>& X,
                        const std::vector<std::array<int, 4>>& cells, const std::vector<int>& cell_material);

}  // namespace palpate

#pragma once

#include <vector>

#include "discretization/cells/background_cells.h"
#include "discretization/cells/integration_points.h"
#include "scene/scene.h"

namespace palpate {

/// Tissue that mixes by an image (paper section 5): of the material with a membership (MaterialSpec::membership) and
/// the first one, each integration point gets
///
///   mu = mu_0^(1 - s) mu_m^s,  K likewise,  rho = (1 - s) rho_0 + s rho_m,   s the mean membership over its cells
///
/// in the paper's scheme mu = (1 - s) mu_0 + s mu_m. Where a border runs through voxels and cells, one tissue beside
/// the other, that is too stiff: a ball over a lump of 5 or 20 times the modulus was 11 and 28 % off; by the mean of
/// the compliances one over as soft a lump 8 and 24 % too soft. The geometric mean is between: 6 and 13, 2 and 9 %.
///
/// The shares are rounded to 1/255 (mixture_steps), so that moduli are exact to 0.6 % at a ratio of 20, and the
/// mixtures are materials like all others: the stable step, mass scaling, node patches, pairs of cells and all that
/// asks for a point's material needed no change. Only the kernel computes all of them in common (mixtureBases), so that
/// neighbouring points share their nodes whatever they are made of, and a scene that does not mix runs the same code as
/// before.

/// Place of the material with a membership, or 0 where none has one.
int mixedMaterial(const Scene& scene);

/// Of a point's bulk modulus what node patches leave to the point itself, in shear moduli (makeNodePatches): the
/// scene's, and more where tissue mixes: it changes over a few edges, and its pressure with it.
double ownBulk(const Scene& scene);

/// Whether the scene's volume is averaged over node patches: with a bulk modulus that is all left to the points,
/// nothing would be averaged.
bool needsPatches(const Scene& scene);

/// The scene's materials and then, where it mixes, those between: what point_material counts.
std::vector<Material> materialsOf(const Scene& scene);

/// Of each of materialsOf the one that the kernel computes it by; empty where nothing mixes.
std::vector<int> mixtureBases(const Scene& scene);

/// Of the moduli of two tissues that of their mixture, Pa. @param share  of the second
double mixedModulus(const Scene& scene, double first, double second, double share);

/// Mean membership over each cell (cell_count). Throws InputError where the image leaves out a part of what mixes.
/// @pre  mixedMaterial(scene) != 0
/// @param cell_material  (cell_count) those of the first material mix
std::vector<double> cellShares(const Scene& scene, const std::vector<Vec3>& X, const BackgroundCells& cells,
                               const std::vector<int>& cell_material);

/// Replaces the first material by the mixture of each cell.
void mixCells(const Scene& scene, const std::vector<double>& share, std::vector<int>& cell_material);

/// Replaces the first material by the mixture of each point's cells, by their volumes.
void mixPoints(const Scene& scene, const std::vector<double>& share, const BackgroundCells& cells,
               const IntegrationPoints& points, std::vector<int>& point_material);

}  // namespace palpate

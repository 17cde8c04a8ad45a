#pragma once

#include "imaging/image.h"

namespace palpate {

/// What keepLargestPart left out and filled.
struct MaskParts {
  int part_count = 0;              // before, joined across faces of voxels
  std::size_t dropped_voxels = 0;  // of all parts but the largest
  std::size_t filled_voxels = 0;   // of holes that the outside does not reach
};

/// Keeps the largest part of a mask and fills the holes in it: what an organ's outside is.
Mask keepLargestPart(const Mask& mask, MaskParts& parts);

/// Leaves out thin tails: the voxels further than `reach` from where a ball of `radius`, m, gets within the mask.
Mask withoutTails(const Mask& mask, double radius, double reach);

/// Distance of each voxel's centre to the mask's border, m; negative inside. Exact between voxels' centres
/// (Felzenszwalb and Huttenlocher 2012), the border being half a voxel before the first centre on the other side. On
/// sheared grids along the axes.
/// @pre  the mask has voxels inside and outside
Image signedDistance(const Mask& mask);

/// Smooths by a Gaussian with this standard deviation along each axis, in m whatever the voxels. Values beyond the
/// edges are those at the edges.
void smooth(Image& image, double sigma);

/// The part of the image around a mask, with a margin (m) that may go beyond the image, where nothing is inside.
Mask croppedTo(const Mask& mask, double margin);

}  // namespace palpate

#pragma once

#include "discretization/surface/triangle_surface.h"
#include "imaging/image.h"

namespace palpate::tools {

/// How a surface was made from a mask.
struct MaskSurface {
  TriangleSurface surface;
  double volume = 0, mask_volume = 0;  // m^3
  double level = 0;                    // m, of the mask's smoothed signed distance; chosen for the volume
  double smoothing = 0;                // m, standard deviation; may have been raised
  double distance_95 = 0;              // m, within which 95 % of the surface's vertices are of the mask's border
};

/// A closed surface of even triangles around a mask: the level of its signed distance, smoothed by a Gaussian, at which
/// the volume is the mask's to 0.5 %. In the world, whatever the voxels' axes.
/// @param mask       one part without holes (keepLargestPart)
/// @param edge       m, of the triangles
/// @param smoothing  m, standard deviation; doubled up to twice where the surface would pierce itself
/// Throws InputError where no such surface is found.
MaskSurface surfaceOf(const Mask& mask, double edge, double smoothing);

}  // namespace palpate::tools

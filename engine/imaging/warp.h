#pragma once

#include <functional>

#include "imaging/deformation.h"

namespace palpate {

/// For each voxel of a grid in the world as it is now: where it came from.
struct BackwardField {
  VectorImage to_rest;  // m, RAS: the voxel at x shows what was at x + to_rest(x); zero outside the body
  Image jacobian;       // volume now over volume at rest; 1 outside the body
  Mask body;            // 1 where the body is now
  Mask vacated;         // 1 where the body was and is no more
};

/// @param inverse   of `forward`
/// @param progress  told the share that is done; may throw
/// Test: imaging/warp_test.cpp
BackwardField backwardField(const SampledDeformation& forward, const InverseDeformation& inverse, const ImageGrid& grid,
                            const std::function<void(double)>& progress = {});

/// u at the voxels of a grid of the body at rest, m; zero outside the body.
VectorImage forwardField(const SampledDeformation& forward, const ImageGrid& grid);

/// How values are taken between voxels: of intensities, of labels, of memberships.
enum class Between { Cubic, Nearest, Linear };

/// An image as it is after the deformation, on the field's grid. Outside the body it is what it was; where the body was
/// and is no more, and beyond the image, there is `fill`.
Image warped(const Image& image, const BackwardField& field, Between between, float fill);

/// 1 where `warped` shows something of the image, 0 where it has the fill value.
Mask validOf(const ImageGrid& image, const BackwardField& field);

/// Of voxels of the body chosen by lot: how far the sampled field's inverse is from that of the whole field, m, and
/// from coming back (forward after inverse).
struct WarpCheck {
  int count = 0;
  double mean = 0, max = 0;
  double round_trip = 0;  // max |X + u(X) - x|, of the field written
};
WarpCheck checkField(const BackwardField& field, const Deformation& whole, const InverseDeformation& inverse,
                     int count);

}  // namespace palpate

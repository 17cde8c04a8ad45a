#pragma once

#include <vector>

#include "imaging/image.h"
#include "mtled/report/pictures.h"

namespace palpate::tools {

/// A column of slices: an image, and what is laid over it.
struct SliceColumn {
  const Image* image = nullptr;
  const Mask* contour = nullptr;  // its border is drawn in orange; null: none
  const Image* tint = nullptr;    // 0 .. 1, laid over in blue; null: none
};

/// Three slices of each column through a place of the world: axial, coronal, sagittal, one above the other. As
/// radiologists look at them: the patient's right is on the left, the front is on top or on the left.
/// @param box  m, what of the world is shown
/// @param low, high  intensities that are black and white
Picture drawSlices(const std::vector<SliceColumn>& columns, const Box3& box, const Vec3& place, double low,
                   double high);

/// The intensities below which 1 % and 99.5 % of a mask's voxels are.
std::pair<double, double> windowOf(const Image& image, const Mask& mask);

/// The world's box of the voxels that are in a mask, with a margin, m.
Box3 boxOf(const Mask& mask, double margin);

}  // namespace palpate::tools

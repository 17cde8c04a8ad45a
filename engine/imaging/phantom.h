#pragma once

#include <cstdint>
#include <vector>

#include "imaging/image.h"

namespace palpate {

/// A brain by formula: to show and to test the way from a scan to a deformed image where the truth is known. Two
/// hemispheres in one envelope of 136 x 170 x 124 mm, with folds, fluid in the sulci, ventricles and deep grey nuclei;
/// T1 contrast. No patient's data.
struct PhantomOptions {
  int voxels = 128;           // along the longest side of the scan, which is 192 mm long
  double noise = 0.03;        // standard deviation of the Rician noise over the white matter's intensity
  double bias = 0.4;          // the field's range: the brightest place over the darkest, less 1
  double shift = 12e-3;       // m, how far the middle electrode is pushed in
  int rows = 6, columns = 8;  // of the electrode grid, 10 mm apart
  std::uint64_t seed = 1;
};

enum class PhantomTissue { Fluid, Grey, White };

struct Phantom {
  Image scan;
  Mask mask;                        // of the brain with the fluid in its sulci: what skull stripping would leave
  Image labels;                     // 1 fluid, 2 grey, 3 white: the larger share of each voxel
  std::vector<Image> fraction;      // (3) of each tissue in the voxel: the truth of the memberships
  Image bias;                       // the factor in the scan
  std::vector<Vec3> before, after;  // (electrode_count) m
};

/// The phantom's tissue at a place of the world, m; `inside` false outside the envelope.
PhantomTissue phantomTissue(const Vec3& X, bool& inside);

/// Same options, same bytes (on one machine).
Phantom makePhantom(const PhantomOptions& options);

}  // namespace palpate

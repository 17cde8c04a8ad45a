#pragma once

#include <string>

namespace palpate::tools {

struct WarpOptions {
  std::string folder;   // of the case, solved
  std::string image;    // NIfTI; "": the fields only, which then needs `like`
  bool labels = false;  // whole numbers that name things: nearest voxel instead of cubic
  std::string like;     // NIfTI whose voxels the results have; "": the image's
  float fill = 0;       // where tissue was and is no more
  bool assume_ras = false;
  std::string out;  // folder; "": that of the case
};

/// Warps an image by a case's solution. Writes field.nii.gz (displacements from the deformed to the reference image, as
/// ITK's resampling wants them), forward.nii.gz (from the reference to the deformed), warped.nii.gz, valid.nii.gz,
/// jacobian.nii.gz (volume now over volume at rest, where the tissue is now), shift.png and warp.json with a check
/// against the whole field.
/// @return 0, or 1 where it was interrupted
/// Throws InputError where the case was not solved as its scene now is, or an image can't be used.
int warpCommand(const WarpOptions& options);

}  // namespace palpate::tools
